// Copies of the host's arrays in a card's memory, for ArrayCopies (backend/copy_arrays.h): those
// that stay from launch to launch, and those of one launch.
#pragma once

#include <cstddef>
#include <cstring>
#include <map>
#include <utility>
#include <vector>

#include "backend/cuda/card.h"
#include "backend/cuda/card_outputs.h"
#include "physics/views/version.h"

namespace omma {

// Copies that stay, by where the host's arrays are. An array is copied again when its version is
// another; those that no launch has read for long go where memory is short.
class KeptCopies {
 public:
  explicit KeptCopies(bool checks_copies) : checks_(checks_copies) {}

  void begin_launch() { ++launch_; }
  const void* read(const Card& card, const void* array, std::size_t bytes, Version version);
  // Frees what the present launch has not read; whether there was any.
  bool free_unused(const Card& card);

  std::size_t copied = 0;  // bytes since this was set

 private:
  struct Copy {
    CardPointer at = 0;
    Version version = 0;
    std::uint64_t last_read = 0;  // launch
  };

  bool checks_;
  std::uint64_t launch_ = 0;
  std::map<std::pair<const void*, std::size_t>, Copy> kept_;
};

// Gives up what is kept, but for what the present launch has read, before it fails.
CardPointer allocate(const Card& card, KeptCopies& kept, std::size_t bytes);

// Memory for the threads of a launch. Returns the blocks of the grid that it is launched with: as
// many as run at once, fewer where so many are not wanted or, when what is kept has been given up,
// their memory is not there: that takes longer, and is right too.
int give_memory(Card& card, KeptCopies& kept, CardKernel kernel, std::int64_t wanted,
                GridLaunch& launch);

// Memory that is the same on both sides: written here, sent in one transfer for each piece, and
// brought back so.
class MirroredMemory {
 public:
  // Where `bytes` from here will be on the card.
  void* add(const Card& card, KeptCopies& kept, const void* from, std::size_t bytes);
  void send(const Card& card) const;
  void bring_back(const Card& card);
  // Where on the host is what is there on the card.
  const std::byte* host(const void* on_card) const;
  // For the next launch; large pieces are given back.
  void clear(const Card& card);

 private:
  struct Piece {
    CardPointer at;
    std::vector<std::byte> host;
    std::size_t used;
  };

  std::vector<Piece> pieces_;
};

// Of one launch.
class LaunchCopies {
 public:
  LaunchCopies(const Card& card, KeptCopies& kept, MirroredMemory& read, MirroredMemory& written)
      : card_(card), kept_(kept), read_(read), written_(written) {
    kept_.begin_launch();
    read_.clear(card);
    written_.clear(card);
  }

  template <typename T>
  const T* read(const T* array, std::size_t count, Version version) {
    const std::size_t bytes = count * sizeof(T);
    return static_cast<const T*>(version != 0 ? kept_.read(card_, array, bytes, version)
                                              : read_.add(card_, kept_, array, bytes));
  }
  template <typename T>
  T* written(T* array, std::size_t count) {
    const std::size_t bytes = count * sizeof(T);
    if (const std::optional<CardOutput> there = find_card_output(array, bytes)) {
      stream_ = reinterpret_cast<void*>(there->stream);
      return array;
    }
    void* const place = written_.add(card_, kept_, array, bytes);
    outputs_.push_back({array, place, bytes});
    return static_cast<T*>(place);
  }
  // That kernels are to run on, once all arrays are known.
  void* stream() const { return stream_; }
  void send() const {
    read_.send(card_);
    written_.send(card_);
  }
  // What was written goes to where it was asked for.
  void bring_back() {
    written_.bring_back(card_);
    for (const Output& output : outputs_)
      std::memcpy(output.host, written_.host(output.place), output.bytes);
  }

 private:
  struct Output {
    void* host;
    const void* place;
    std::size_t bytes;
  };

  const Card& card_;
  KeptCopies& kept_;
  MirroredMemory &read_, &written_;
  std::vector<Output> outputs_;
  void* stream_ = nullptr;
};

}  // namespace omma
