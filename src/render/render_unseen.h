// Things that the rays of some poses do not meet on their way from the eye.
#pragma once

#include "omma/render.h"
#include "world/world_state.h"

namespace omma {

// Throws omma::Error where groups, or the group of a pose, are not of this world.
void check_unseen(const BuiltScene& built, const RenderCall& call, std::size_t poses);

// Sets the masks while it lives. Masks are applied where instances are placed, so what is unseen
// must be among the moves before and after.
class UnseenMarks {
 public:
  UnseenMarks(BuiltScene& built, const RenderCall& call);
  UnseenMarks(const UnseenMarks&) = delete;
  UnseenMarks& operator=(const UnseenMarks&) = delete;
  ~UnseenMarks() { remove(); }

  void remove() { seen_by_.clear(); }

 private:
  std::vector<std::uint32_t>& seen_by_;
};

// Moves that leave what is not seen where it is, so that it takes its marks.
void add_unseen(const BuiltScene& built, const RenderCall& call, Moves& moves);

}  // namespace omma
