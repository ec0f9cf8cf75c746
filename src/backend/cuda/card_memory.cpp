// Allocations on a card, and what goes to and fro.
#include "backend/cuda/card_memory.h"

#include <algorithm>

#include "omma/error.h"
#include "physics/rays/replicates.h"

namespace omma {
namespace {

constexpr std::size_t least_piece = std::size_t{1} << 20;    // bytes
constexpr std::size_t largest_stays = std::size_t{1} << 28;  // of pieces, from launch to launch

void* pointer(CardPointer at) {
  return reinterpret_cast<void*>(at);
}

}  // namespace

CardPointer allocate(const Card& card, KeptCopies& kept, std::size_t bytes) {
  for (;;) {
    if (const CardPointer at = try_to_allocate(card, bytes)) return at;
    if (!kept.free_unused(card)) fail_for_memory(card, bytes);
  }
}

const void* KeptCopies::read(const Card& card, const void* array, std::size_t bytes,
                             Version version) {
  Copy& copy = kept_[{array, bytes}];
  const bool is_new = copy.at == 0;
  copy.last_read = launch_;
  if (is_new) copy.at = allocate(card, *this, std::max<std::size_t>(bytes, 1));
  if (is_new || copy.version != version) {
    copy_to_card(card, copy.at, array, bytes);
    copy.version = version;
    copied += bytes;
  } else if (checks_) {
    std::vector<std::byte> on_card(bytes);
    copy_from_card(card, on_card.data(), copy.at, bytes);
    if (std::memcmp(on_card.data(), array, bytes) != 0)
      throw Error(card.name + ": an array of " + std::to_string(bytes) +
                  " bytes has changed, and has the version that it had");
  }
  return pointer(copy.at);
}

bool KeptCopies::free_unused(const Card& card) {
  bool any = false;
  for (auto it = kept_.begin(); it != kept_.end();) {
    const Copy& copy = it->second;
    const bool is_unused = copy.last_read != launch_ && copy.at != 0;
    any = any || is_unused;
    if (is_unused) free_memory(card, copy.at);
    it = is_unused ? kept_.erase(it) : std::next(it);
  }
  return any;
}

void* MirroredMemory::add(const Card& card, KeptCopies& kept, const void* from, std::size_t bytes) {
  const std::size_t room = (bytes + 127) / 64 * 64;  // something lies between arrays
  auto piece = std::find_if(pieces_.begin(), pieces_.end(),
                            [&](const Piece& p) { return p.host.size() - p.used >= room; });
  if (piece == pieces_.end()) {
    const std::size_t size = std::max(room, least_piece);
    pieces_.push_back({allocate(card, kept, size), std::vector<std::byte>(size), 0});
    piece = std::prev(pieces_.end());
  }
  if (bytes > 0) std::memcpy(piece->host.data() + piece->used, from, bytes);
  void* const place = pointer(piece->at + piece->used);
  piece->used += room;
  return place;
}

void MirroredMemory::send(const Card& card) const {
  for (const Piece& piece : pieces_) copy_to_card(card, piece.at, piece.host.data(), piece.used);
}

void MirroredMemory::bring_back(const Card& card) {
  for (Piece& piece : pieces_) copy_from_card(card, piece.host.data(), piece.at, piece.used);
}

const std::byte* MirroredMemory::host(const void* on_card) const {
  const auto at = reinterpret_cast<CardPointer>(on_card);
  for (const Piece& piece : pieces_)
    if (at >= piece.at && at < piece.at + piece.used) return piece.host.data() + (at - piece.at);
  return nullptr;
}

void MirroredMemory::clear(const Card& card) {
  std::erase_if(pieces_, [&](const Piece& piece) {
    const bool goes = piece.host.size() > largest_stays;
    if (goes) free_memory(card, piece.at);
    return goes;
  });
  for (Piece& piece : pieces_) piece.used = 0;
}

int give_memory(Card& card, KeptCopies& kept, CardKernel kernel, std::int64_t wanted,
                GridLaunch& launch) {
  const std::int64_t at_once = card.blocks_at_once[static_cast<int>(kernel)];
  std::int64_t blocks = std::max<std::int64_t>(1, std::min(wanted, at_once));
  const std::size_t each = launch.block_bytes + most_per_block * launch.thread_bytes;
  const auto needed = [&] { return static_cast<std::size_t>(blocks) * each; };
  if (needed() > card.thread_memory_bytes) {
    if (card.thread_memory != 0) free_memory(card, card.thread_memory);
    card.thread_memory_bytes = 0;
    while ((card.thread_memory = try_to_allocate(card, needed())) == 0) {
      if (kept.free_unused(card)) continue;
      if (blocks == 1) fail_for_memory(card, needed());
      blocks /= 2;
    }
    card.thread_memory_bytes = needed();
  }
  launch.memory = reinterpret_cast<std::byte*>(card.thread_memory);
  return static_cast<int>(blocks);
}

}  // namespace omma
