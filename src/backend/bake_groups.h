// Estimates and reduces the noise of baked light. A bake has two independent halves: among
// neighbouring cells that face alike, what the halves share is variation of light, their difference
// is noise. A plane is fitted to the light of such a group, and residuals are shrunk by their share
// of noise.
#pragma once

#include <cstdint>
#include <vector>

#include "backend/bake_owners.h"

namespace omma {

// Sides of cells that face alike in a cube of space a few cells wide; of one size, to a factor of 2.
struct BakeGroups {
  std::vector<std::int64_t> first;    // [group + 1], into `side`
  std::vector<std::int32_t> side;     // 2 * cell + (0 front, 1 back)
  std::vector<Vec3> middle;           // of the cells of `side`, traced frame, m
  std::vector<std::uint16_t> signs;   // [group], CellError::signs
  std::vector<std::int32_t> region;   // [group], of groups about eight times as wide in space
  std::int32_t regions = 0;

  std::size_t count() const { return signs.size(); }
  std::int64_t members(std::size_t group) const { return first[group + 1] - first[group]; }
};

BakeGroups group_cells(const BakedLight& plan, const CellOwners& owners, const SceneView& view,
                       const Scene& scene, const Placement& placement);

// Of a group, as squares of fractions of its light, in the mean over bands.
struct GroupNoise {
  bool is_lit = false;  // whether anything was found
  double own = 0;       // variance of the mean of the halves of one cell, from independent noise
  double varies = 0;    // of what cells have beside the plane, noise aside
  double apart = 0;     // square of half the difference of the halves' means
};

// [half][cell][front, back][band] as of BakedLight::lines.
std::vector<GroupNoise> find_noise(const BakeGroups& groups, int bands,
                                   const BakedLine* const (&half)[2]);

// The mean of both halves, shared, and how far it may be off at a point of a cell.
void share_mean(const BakeGroups& groups, const std::vector<GroupNoise>& noise,
                const BakedLine* const (&half)[2], BakedLight& baked);

// Paths of each half for each group, at most about `most` together: in proportion to the standard
// deviation of one, as a fraction of light, which leaves the least variance in the mean (J. Neyman
// 1934). `variance_of_path` [group].
std::vector<std::uint16_t> share_paths(const BakeGroups& groups,
                                       const std::vector<double>& variance_of_path, double most);

}  // namespace omma
