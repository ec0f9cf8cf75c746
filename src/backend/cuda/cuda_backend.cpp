// The host's side of a card: copies what a launch reads and the card does not have yet, runs a
// kernel, and brings back what it wrote.
#include "backend/cuda/cuda_backend.h"

#include <algorithm>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "backend/copy_arrays.h"
#include "backend/cuda/card_memory.h"
#include "backend/cuda/compile.h"
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

// The card, from when it is first asked for, with what stays on it.
struct OpenCard {
  CardLibraries libraries = card_libraries();
  Card card = open_card(libraries);
  KeptCopies kept{libraries.checks_copies};
  MirroredMemory read, written;
};

std::mutex one_at_a_time;
std::unique_ptr<OpenCard> opened;

// The caller holds one_at_a_time. An error stays no error: it is asked again the next time.
OpenCard& the_card() {
  if (opened == nullptr) opened = std::make_unique<OpenCard>();
  use_card(opened->card);
  return *opened;
}

// A launch that is put together.
class Launch {
 public:
  explicit Launch(CardKernel kernel) : kernel_(kernel) {}

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

  std::lock_guard<std::mutex> lock_{one_at_a_time};
  OpenCard& open_ = the_card();
  LaunchCopies copies_{open_.card, open_.kept, open_.read, open_.written};
  ArrayCopies<LaunchCopies> arrays_{copies_};
  CardKernel kernel_;
  GridLaunch launch_;
};

void render_tasks(CardKernel kernel, const FrameView& frame, std::span<const BlockTask> tasks,
                  const void* tracer) {
  Launch launch(kernel);
  launch.search(tracer);
  launch.render(frame, 1);
  launch.run_tasks(tasks, most_per_block, frame);
}

Launches launches() {
  Launches all;
  all.render = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    render_tasks(CardKernel::render, frame, tasks, tracer);
  };
  all.discs = [](const FrameView& frame, std::span<const BlockTask> tasks, const void* tracer) {
    render_tasks(CardKernel::discs, frame, tasks, tracer);
  };
  all.gather = [](const FrameView& frame, std::span<const GatherTask> tasks, const void* tracer) {
    Launch launch(CardKernel::gather);
    launch.search(tracer);
    launch.render(frame, packet_rays);
    launch.run_tasks(tasks, 1, frame.scene->bands);
  };
  all.weigh = [](const SharedWeights& shared, int outputs, std::span<const WeighTask> tasks) {
    Launch launch(CardKernel::weigh);
    launch.weigh(shared, outputs);
    launch.run_tasks(tasks, std::max<std::int64_t>(1, shared.ommatidium_count), shared, outputs);
  };
  all.closest = [](std::span<RayPacket<packet_rays>> packets, const void* tracer) {
    Launch launch(CardKernel::closest);
    launch.search(tracer);
    launch.run_packets(packets);
  };
  return all;
}

Acceleration build(const Scene& scene, const SceneView& view, const Placement& placement,
                   WorkState* work) {
  std::string name;
  {
    const std::lock_guard lock(one_at_a_time);
    Card& card = the_card().card;
    load_kernel(card, CardKernel::render);
    name = card.name;
  }
  return {portable_backend().build(scene, view, placement, work).tracer, name};
}

}  // namespace

Backend cuda_backend() {
  return {"cuda", build, portable_backend().move, launches};
}

CardState card_state() {
  CardState state;
  try {
    const CardLibraries libraries = card_libraries();
    const Card card = find_card(libraries);
    state.name = card.name;
    state.driver = std::to_string(card.cuda_version / 1000) + "." +
                   std::to_string(card.cuda_version % 1000 / 10);
    const KernelRequest wanted = kernels_for(card);
    if (!packaged_kernels(wanted, render_program) || !packaged_kernels(wanted, gather_program))
      (void)compile_options(Nvrtc(wanted.nvrtc), wanted.capability);
  } catch (const Error& error) {
    state.why_not = error.what();
  }
  return state;
}

std::string card_note() {
  const std::lock_guard lock(one_at_a_time);
  Card& card = the_card().card;
  load_kernel(card, CardKernel::render);
  return card.note;
}

CardPointer allocate_on_card(std::size_t bytes) {
  const std::lock_guard lock(one_at_a_time);
  OpenCard& open = the_card();
  open.kept.begin_launch();  // of the last one nothing is needed any more
  return allocate(open.card, open.kept, std::max<std::size_t>(bytes, 1));
}

void free_on_card(CardPointer at) {
  const std::lock_guard lock(one_at_a_time);
  free_memory(the_card().card, at);
}

void read_from_card(void* to, CardPointer from, std::size_t bytes) {
  const std::lock_guard lock(one_at_a_time);
  copy_from_card(the_card().card, to, from, bytes);
}

void write_to_card(CardPointer to, const void* from, std::size_t bytes) {
  const std::lock_guard lock(one_at_a_time);
  copy_to_card(the_card().card, to, from, bytes);
}

void wait_for_card() {
  const std::lock_guard lock(one_at_a_time);
  wait_for(the_card().card);
}

void check_on_card(CardPointer at) {
  const std::lock_guard lock(one_at_a_time);
  const Card& card = the_card().card;
  int ordinal = 0;
  const int result = card.driver.pointer_attribute(&ordinal, pointer_ordinal, at);
  if (result != 0 || ordinal != 0)
    throw Error(
        "expected an array on " + card.name + ", found one " +
        (result != 0 ? "that the driver does not know" : "on cuda:" + std::to_string(ordinal)));
}

std::size_t take_kept_bytes() {
  const std::lock_guard lock(one_at_a_time);
  return opened != nullptr ? std::exchange(opened->kept.copied, 0) : 0;
}

}  // namespace omma
