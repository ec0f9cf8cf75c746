// The host's side of cards: copies what a launch reads and a card does not have yet, runs a kernel,
// and brings back what it wrote.
#include "backend/cuda/cuda_backend.h"

#include <algorithm>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "backend/copy_arrays.h"
#include "backend/cuda/card_memory.h"
#include "backend/cuda/compile.h"
#include "backend/cuda/share_out.h"
#include "backend/portable/portable_backend.h"
#include "backend/portable/portable_tracer.h"
#include "omma/error.h"
#include "physics/block/thread.h"
#include "threads/cancel.h"

namespace omma {
namespace {

// Each thread of the grid does so much one after the other; between launches it is asked whether
// all is cancelled.
constexpr std::int64_t turns_per_launch = 32;

// A card, from when it is first asked for, with what stays on it.
struct OpenCard {
  explicit OpenCard(int ordinal) : card(open_card(libraries, ordinal)) {}

  CardLibraries libraries = card_libraries();
  Card card;
  KeptCopies kept{libraries.checks_copies};
  MirroredMemory read, written;
};

struct CardEntry {
  std::mutex one_at_a_time;
  std::unique_ptr<OpenCard> opened;
};

std::mutex entries_mutex;
std::map<int, CardEntry> entries;  // by ordinal; none goes

CardEntry& entry_of(int ordinal) {
  const std::lock_guard lock(entries_mutex);
  return entries[ordinal];
}

// The caller holds the entry's one_at_a_time. An error stays no error: it is asked again the next
// time.
OpenCard& open_at(CardEntry& entry, int ordinal) {
  if (entry.opened == nullptr) entry.opened = std::make_unique<OpenCard>(ordinal);
  use_card(entry.opened->card);
  return *entry.opened;
}

// Those given, or the first one.
std::vector<int> cards_of(std::span<const int> devices) {
  if (devices.empty()) return {0};
  return {devices.begin(), devices.end()};
}

void check_devices(std::span<const int> devices) {
  if (devices.empty()) return;
  const std::vector<std::string> names = card_names(card_libraries());
  std::string all;
  for (const std::string& name : names) all += (all.empty() ? "" : ", ") + name;
  for (const int device : devices) {
    if (device < 0 || static_cast<std::size_t>(device) >= names.size())
      throw Error("devices: expected ordinals below " + std::to_string(names.size()) +
                  ", as the driver has " + all + "; found " + std::to_string(device));
    if (std::count(devices.begin(), devices.end(), device) > 1)
      throw Error("devices: expected each card once, found " + std::to_string(device) + " twice");
  }
}

// A launch that is put together.
class Launch {
 public:
  Launch(CardKernel kernel, int ordinal)
      : entry_(entry_of(ordinal)), open_(open_at(entry_, ordinal)), kernel_(kernel) {}

  template <typename View, typename... More>
  const View* view(View copied, const More&... more) {
    arrays_.point_to_copies(copied, more...);
    return copies_.read(&copied, 1, Version{0});
  }
  void search(const void* built) {
    const auto* tracer = static_cast<const PortableTracer*>(built);
    launch_.searched = view(*tracer->scene_view);
    launch_.bvh = view(tracer->view);
  }
  void render(const FrameView& frame, int lanes) {
    launch_.frame = view(frame);
    Scratch of_packet, of_block;
    if (lanes > 1) lay_out(of_packet, frame, lanes);
    if (frame.most_samples > 0) lay_out_error(of_block, frame);
    launch_.thread_bytes = lanes > 1 ? of_packet.used : thread_bytes(frame);
    launch_.block_bytes = of_block.used;
  }
  void weigh(const SharedWeights& shared, int outputs) {
    launch_.shared = view(shared);
    launch_.outputs = outputs;
  }

  // `threads`: of a task.
  template <typename Task, typename... More>
  void run_tasks(std::span<const Task> tasks, std::int64_t threads, const More&... more) {
    std::vector<Task> own(tasks.begin(), tasks.end());
    for (Task& task : own) arrays_.point_to_copies(task, more...);
    run(copies_.read(own.data(), own.size(), Version{0}), own.size(), threads);
  }
  void run_packets(std::span<RayPacket<packet_rays>> packets) {
    Scratch visits;
    lay_out_visits(visits);
    launch_.thread_bytes = visits.used;
    run(copies_.written(packets.data(), packets.size()), packets.size(), packet_rays);
  }

 private:
  template <typename Task>
  void run(const Task* tasks, std::size_t count, std::int64_t threads) {
    Card& card = open_.card;
    launch_.threads_each = threads;
    copies_.send();
    load_kernel(card, kernel_);
    const auto all = static_cast<std::int64_t>(count);
    const auto blocks_for = [&](std::int64_t n) {
      return (n * threads + most_per_block - 1) / most_per_block;
    };
    const int most = give_memory(card, open_.kept, kernel_, blocks_for(all), launch_);
    const std::int64_t step =
        std::max<std::int64_t>(1, most * most_per_block * turns_per_launch / threads);
    for (std::int64_t k = 0; k < all; k += step) {
      check_cancelled();
      launch_.tasks = tasks + k;
      launch_.count = std::min(step, all - k);
      const std::int64_t blocks = std::min<std::int64_t>(most, blocks_for(launch_.count));
      omma::run(card, kernel_, static_cast<int>(blocks), launch_, copies_.stream());
    }
    copies_.bring_back();
  }

  CardEntry& entry_;
  std::lock_guard<std::mutex> lock_{entry_.one_at_a_time};
  OpenCard& open_;
  LaunchCopies copies_{open_.card, open_.kept, open_.read, open_.written};
  ArrayCopies<LaunchCopies> arrays_{copies_};
  CardKernel kernel_;
  GridLaunch launch_;
};

using BlockTasks = std::span<const BlockTask>;
using GatherTasks = std::span<const GatherTask>;
using WeighTasks = std::span<const WeighTask>;
using Packets = std::span<RayPacket<packet_rays>>;

// Of a task: an ommatidium each, as many as there are in the largest. Tasks to an error have a block
// of the grid each.
std::int64_t threads_of(const FrameView& frame, CardKernel kernel, BlockTasks tasks) {
  if (kernel == CardKernel::render && frame.most_samples > 0) return most_per_block;
  int most = 1;
  for (const BlockTask& task : tasks) most = std::max(most, task.count);
  return most;
}

auto render_on(std::vector<int> cards, CardKernel kernel) {
  return [cards = std::move(cards), kernel](const FrameView& frame, BlockTasks tasks,
                                            const void* tracer) {
    share_out(cards, tasks, [&](int card, BlockTasks piece) {
      Launch launch(kernel, card);
      launch.search(tracer);
      launch.render(frame, 1);
      launch.run_tasks(piece, threads_of(frame, kernel, piece), frame);
    });
  };
}

Launches launches(std::span<const int> devices) {
  check_devices(devices);
  const std::vector<int> cards = cards_of(devices);
  Launches all;
  all.render = render_on(cards, CardKernel::render);
  all.discs = render_on(cards, CardKernel::discs);
  all.gather = [cards](const FrameView& frame, GatherTasks tasks, const void* tracer) {
    share_out(cards, tasks, [&](int card, GatherTasks piece) {
      Launch launch(CardKernel::gather, card);
      launch.search(tracer);
      launch.render(frame, packet_rays);
      launch.run_tasks(piece, 1, frame.scene->bands);
    });
  };
  all.weigh = [cards](const SharedWeights& shared, int outputs, WeighTasks tasks) {
    share_out(cards, tasks, [&](int card, WeighTasks piece) {
      Launch launch(CardKernel::weigh, card);
      launch.weigh(shared, outputs);
      launch.run_tasks(piece, std::max<std::int64_t>(1, shared.ommatidium_count), shared, outputs);
    });
  };
  all.closest = [cards](Packets packets, const void* tracer) {
    share_out(cards, packets, [&](int card, Packets piece) {
      Launch launch(CardKernel::closest, card);
      launch.search(tracer);
      launch.run_packets(piece);
    });
  };
  return all;
}

// Opens them, with the kernels that render; their names and notes.
std::vector<std::pair<std::string, std::string>> open_cards(std::span<const int> devices) {
  std::vector<std::pair<std::string, std::string>> opened;
  for (const int ordinal : cards_of(devices)) {
    CardEntry& entry = entry_of(ordinal);
    const std::lock_guard lock(entry.one_at_a_time);
    Card& card = open_at(entry, ordinal).card;
    load_kernel(card, CardKernel::render);
    opened.emplace_back(card.name, card.note);
  }
  return opened;
}

Acceleration build(const Scene& scene, const SceneView& view, const Placement& placement,
                   std::span<const int> devices, WorkState* work) {
  std::string name;
  for (const auto& [of_card, note] : open_cards(devices))
    name += (name.empty() ? "" : ", ") + of_card;
  return {portable_backend().build(scene, view, placement, {}, work).tracer, name,
          cards_of(devices)};
}

CardState state_of(const CardLibraries& libraries, int ordinal, const std::string& name) {
  CardState state{name, {}, {}};
  try {
    const Card card = find_card(libraries, ordinal);
    state.driver = std::to_string(card.cuda_version / 1000) + "." +
                   std::to_string(card.cuda_version % 1000 / 10);
    const KernelRequest wanted = kernel_request(card);
    if (!packaged_kernels(wanted, render_program) || !packaged_kernels(wanted, gather_program))
      (void)compile_options(Nvrtc(wanted.nvrtc), wanted.capability);
  } catch (const Error& error) {
    state.why_not = error.what();
  }
  return state;
}

// Calls work(open card) while nothing else is asked of it.
template <typename Work>
auto with_card(int ordinal, const Work& work) {
  CardEntry& entry = entry_of(ordinal);
  const std::lock_guard lock(entry.one_at_a_time);
  return work(open_at(entry, ordinal));
}

}  // namespace

Backend cuda_backend() {
  return {"cuda", build, portable_backend().move, launches};
}

std::vector<CardState> card_states() {
  const CardLibraries libraries = card_libraries();
  std::vector<CardState> states;
  try {
    for (const std::string& name : card_names(libraries))
      states.push_back(state_of(libraries, static_cast<int>(states.size()), name));
  } catch (const NoCard& error) {
    states.assign(1, {"", "", error.what()});
  } catch (const Error& error) {
    states.assign(1, {"a graphics card", "", error.what()});
  }
  return states;
}

std::string card_note(std::span<const int> devices) {
  check_devices(devices);
  for (const auto& [name, note] : open_cards(devices))
    if (!note.empty()) return note;
  return {};
}

CardPointer allocate_on_card(int card, std::size_t bytes) {
  check_devices({&card, 1});
  return with_card(card, [&](OpenCard& open) {
    open.kept.begin_launch();  // of the last one nothing is needed any more
    return allocate(open.card, open.kept, std::max<std::size_t>(bytes, 1));
  });
}

void free_on_card(int card, CardPointer at) {
  with_card(card, [&](OpenCard& open) { free_memory(open.card, at); });
}

void read_from_card(int card, void* to, CardPointer from, std::size_t bytes) {
  with_card(card, [&](OpenCard& open) {
    wait_for(open.card);
    copy_from_card(open.card, to, from, bytes);
  });
}

void write_to_card(int card, CardPointer to, const void* from, std::size_t bytes) {
  with_card(card, [&](OpenCard& open) {
    // Whoever uses it may do so in a stream that does not wait for copies, before and after.
    wait_for(open.card);
    copy_to_card(open.card, to, from, bytes);
    wait_for(open.card);
  });
}

void wait_for_card(int card) {
  with_card(card, [&](OpenCard& open) { wait_for(open.card); });
}

int card_of(CardPointer at) {
  return with_card(0, [&](OpenCard& open) {
    int ordinal = 0;
    if (open.card.driver.pointer_attribute(&ordinal, pointer_ordinal, at) != 0)
      throw Error("expected an array on a card, found one that the driver does not know");
    return ordinal;
  });
}

std::size_t take_kept_bytes() {
  std::size_t bytes = 0;
  const std::lock_guard lock(entries_mutex);
  for (auto& [ordinal, entry] : entries) {
    const std::lock_guard of_entry(entry.one_at_a_time);
    if (entry.opened != nullptr) bytes += std::exchange(entry.opened->kept.copied, 0);
  }
  return bytes;
}

}  // namespace omma
