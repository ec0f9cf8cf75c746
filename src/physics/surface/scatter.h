// How a surface scatters light, as glTF 2.0 (appendix B) and its extensions say, made to keep
// energy: no surface gives back more than it gets, and a sheet that absorbs nothing gives back all.
//
// Six lobes, each light that takes one way: (1) a diffuse base that reflects rho and (2) transmits
// tau, below (3) a rough dielectric boundary, microfacet.h with Fresnel's reflectance, which
// polarises; (4) a rough metal in their place, by `metallic`; (5) straight through a thin sheet,
// KHR_materials_transmission, in place of the base; (6) a clear coat above all.
//
// What a boundary does not reflect, 1 - E (specular_albedo.h), reaches the base and leaves it:
//
//   f = rho / pi (1 - E(o)) (1 - E(w)) / (1 - mean E),
//
// the coupling of Kelemen and Szirmay-Kalos 2001 (A Microfacet Based Coupled Specular-Matte BRDF
// Model): of uniform light the base returns rho (1 - E(o)). So whatever E is, all together is
// E(o) + (rho + tau) (1 - E(o)). A coat dims what is below it by 1 - E of its own on both ways, and
// keeps the rest; its normal may be another than theirs.
//
// Light that leaves the base is unpolarised below the boundary, which lets more of it out in the
// plane of exit than across it: diffuse_polarization. What gets in is counted as if unpolarised.
//
// Light that facets pass to each other before it leaves: of a dielectric it counts to the base. A
// metal's lobe is made larger by what a white one lacks, its albedo being E: by 1 + f0 (1 - E(o)) /
// E(o) (Turquin 2019, Practical multiple scattering compensation for microfacet models, equations
// 13 and 16), so that a white one returns all. That takes reciprocity: seen along o and w the two
// differ by that factor.
//
// What differs by band (rho, tau, the colour of a metal, or how a stack of thin films in its place
// reflects) is the caller's; lobes are told without.
#pragma once

#include "physics/lanes/vector3.h"
#include "physics/surface/fresnel.h"
#include "physics/surface/specular_albedo.h"

namespace omma {

enum class Lobe : std::int32_t {
  diffuse_reflection,
  diffuse_transmission,
  dielectric,
  metal,
  straight,
  coat
};
inline constexpr int lobe_count = 6;

inline constexpr float coat_ior = 1.5f;  // KHR_materials_clearcoat

// A surface where rays met it. Vectors are unit and in one frame. A ray that met nothing has a
// direction too, and zeros otherwise.
template <typename F>
struct ScatterSurface {
  Vector3<F> direction;         // of the ray, towards the surface
  Vector3<F> geometric_normal;  // of the triangle, towards the viewer
  Vector3<F> normal;            // what light is shaded by, on the same side of the triangle
  Vector3<F> coat_normal;       // the same of the coat
  F roughness, metallic, specular, transmission, ior;
  F coat, coat_roughness;
  const float* albedo_tables;   // [table][albedo_floats], make_specular_albedo of its ior
  decltype(to_int(F{})) table;  // the lane's
  const float* coat_table;      // [albedo_floats], of coat_ior; null: no lane has a coat
  const float* metal_table;     // [albedo_floats], of a white metal; null: no lane is metal
};

// A boundary of small mirrors, as the viewer sees it.
template <typename F>
struct RoughBoundary {
  F alpha, root_o;  // smith_root of o
  AlbedoRow<F> row;
};

// All that does not depend on the direction of the light.
template <typename F>
struct ScatterPoint {
  Vector3<F> tangent, bitangent, normal, geometric_normal, direction;
  // By which the base is lit: the surface's own, not bent towards the viewer, so that what falls on
  // it is the same whoever looks. Likewise the coat's, through which that light comes.
  Vector3<F> base_normal, coat_base_normal;
  LocalDirection<F> o;  // towards the viewer, in the frame of tangent, bitangent, normal
  // The coat's frame, and the viewer in it; anything where nothing has a coat.
  Vector3<F> coat_normal;
  Axes<F> coat_axes;
  LocalDirection<F> coat_o;
  F ior, specular, coat;
  RoughBoundary<F> boundary, coat_boundary;
  const float* albedo_tables;
  const float* coat_table;
  F dielectric_albedo, coat_albedo;  // what the whole lobe gives back of uniform light
  // Shares of lobes, with all that o does to them. Of the base, per sr and to be multiplied by 1 -
  // E of the light's direction; of what goes straight, the whole.
  F base, dielectric, metal, straight;
  F metal_gain;  // (1 - E) / E of a white metal, see metal_color
  F diffuse;     // what the base gives back of uniform light, where rho is 1
  F coupling;    // of the boundary, the 1 / (1 - mean E) that is in `base`
};

// What falls on the surface from direction w and goes to the viewer, over what falls on a surface
// that faces w (the cosine is in it), per sr; and the densities with which sample_scatter finds w.
template <typename F>
struct ScatterValue {
  F diffuse_reflection;    // where rho is 1
  F diffuse_transmission;  // where tau is 1
  Mueller<F> dielectric;   // in the axes s of reflection_axis
  F metal;                 // times metal_color, or a table of its own (boundary_table.h)
  F half_cosine;  // between the half vector of that boundary and the viewer
  Mueller<F> coat;
  F cosine;  // between w and the base's normal
  F boundary_pdf, coat_pdf;
};

// Least cosine between a normal and the viewer. Those of vertices and of normal maps may turn away
// from who sees the triangle: for the lobes that mirror they are bent back, as far as it takes.
inline constexpr float least_cosine = 1e-3f;

template <typename F>
OMMA_HD Vector3<F> bend_normal(const Vector3<F>& normal, const Vector3<F>& direction) {
  const F lacking = least_cosine + dot(normal, direction);
  const F bend = lacking > 0.0f ? lacking : broadcast<F>(0.0f);
  return normalize(normal - direction * bend);  // zero where there is neither
}

// A direction by its components along axes and the normal that they are about.
template <typename F>
OMMA_HD LocalDirection<F> to_local(const Axes<F>& axes, const Vector3<F>& normal,
                                   const Vector3<F>& w) {
  return {dot(axes.tangent, w), dot(axes.bitangent, w), dot(normal, w)};
}
// And back.
template <typename F>
OMMA_HD Vector3<F> from_local(const Axes<F>& axes, const Vector3<F>& normal,
                              const LocalDirection<F>& d) {
  return axes.tangent * d.x + axes.bitangent * d.y + normal * d.z;
}

template <typename F>
OMMA_HD RoughBoundary<F> make_boundary(F roughness, F cos_o, decltype(to_int(F{})) table) {
  const F alpha = microfacet_alpha(roughness);
  return {alpha, smith_root(cos_o, alpha), find_albedo_row(roughness, table)};
}

template <typename F>
OMMA_HD ScatterPoint<F> make_scatter_point(const ScatterSurface<F>& s) {
  const F one = broadcast<F>(1.0f);
  ScatterPoint<F> p;
  p.geometric_normal = s.geometric_normal;
  p.direction = s.direction;
  p.base_normal = s.normal;
  p.normal = bend_normal(s.normal, s.direction);
  const Axes<F> axes = make_axes(p.normal);
  p.tangent = axes.tangent;
  p.bitangent = axes.bitangent;
  const LocalDirection<F> away = to_local(axes, p.normal, s.direction);
  p.o = {-away.x, -away.y, -away.z};
  p.ior = s.ior;
  p.specular = s.specular;
  p.albedo_tables = s.albedo_tables;
  p.boundary = make_boundary(s.roughness, p.o.z, s.table);
  const F albedo_o = s.specular * eval_albedo(s.albedo_tables, p.boundary.row, p.o.z);
  // A boundary that reflects all (ior of thousands) leaves nothing to couple.
  const F entering = 1.0f - s.specular * eval_mean_albedo(s.albedo_tables, p.boundary.row);
  const F coupling = 1.0f / (entering > 1e-3f ? entering : broadcast<F>(1e-3f));

  p.coat = s.coat;
  p.coat_table = s.coat_table;
  p.coat_albedo = broadcast<F>(0.0f);
  if (s.coat_table != nullptr) {
    p.coat_base_normal = s.coat_normal;
    p.coat_normal = bend_normal(s.coat_normal, s.direction);
    p.coat_axes = make_axes(p.coat_normal);
    const LocalDirection<F> from_viewer = to_local(p.coat_axes, p.coat_normal, s.direction);
    p.coat_o = {-from_viewer.x, -from_viewer.y, -from_viewer.z};
    p.coat_boundary = make_boundary(s.coat_roughness, p.coat_o.z, s.table * 0);
    p.coat_albedo = s.coat * eval_albedo(s.coat_table, p.coat_boundary.row, p.coat_o.z);
  }
  const F below_coat = one - p.coat_albedo;
  p.metal = s.metallic * below_coat;
  p.metal_gain = broadcast<F>(0.0f);
  if (s.metal_table != nullptr) {
    AlbedoRow<F> white = p.boundary.row;
    white.table = s.table * 0;
    p.metal_gain = 1.0f / eval_albedo(s.metal_table, white, p.o.z) - 1.0f;
  }
  const F not_metal = (one - s.metallic) * below_coat;
  p.dielectric = not_metal * s.specular;
  p.dielectric_albedo = not_metal * albedo_o;
  const F inside = not_metal - p.dielectric_albedo;
  p.coupling = coupling;
  p.diffuse = inside * (one - s.transmission);
  p.base = p.diffuse * coupling * inverse_pi;
  p.straight = inside * s.transmission * below_coat;
  return p;
}

// The size of a cosine that rounding may have brought over 1.
template <typename F>
OMMA_HD F size_of_cosine(F x) {
  const F size = x < 0.0f ? -x : x;
  return size < 1.0f ? size : broadcast<F>(1.0f);
}

// Q / I of diffuse light that leaves through the boundary, with the axis s across the plane of view
// and normal: -Q(o) / (1 - E(o)). It takes off what the boundary polarises of uniform light, so
// that a white surface leaves such light unpolarised, as thermodynamics asks. Of a smooth boundary
// it is (T_s - T_p) / (T_s + T_p) of what gets out (Wolff and Boult 1991, Constraining object
// features using a polarization reflectance model).
template <typename F>
OMMA_HD F diffuse_polarization(const ScatterPoint<F>& p) {
  const AlbedoRow<F>& row = p.boundary.row;
  const F kept = 1.0f - p.specular * eval_albedo(p.albedo_tables, row, p.o.z);
  const F polarized =
      p.specular * eval_albedo(p.albedo_tables, row, p.o.z, first_polarized_albedo);
  return 0.0f - polarized / (kept > 1e-3f ? kept : broadcast<F>(1e-3f));
}

// What the boundary and the coat let in to the base of light from a direction w, at cos_w to the
// base's normal, over what they let in of uniform light.
template <typename F>
OMMA_HD F eval_entering(const ScatterPoint<F>& p, F cos_w, const Vector3<F>& w) {
  F entering =
      p.coupling * (1.0f - p.specular * eval_albedo(p.albedo_tables, p.boundary.row, cos_w));
  if (p.coat_table != nullptr)
    entering = entering *
               (1.0f - p.coat * eval_albedo(p.coat_table, p.coat_boundary.row,
                                            size_of_cosine(dot(p.coat_base_normal, w))));
  return entering;
}

// `w`: a unit vector towards the light. Light reaches the viewer from the viewer's side of both the
// triangle and the normal of the lobe by reflection, from the far side of both through the sheet.
template <typename F>
OMMA_HD ScatterValue<F> eval_scatter(const ScatterPoint<F>& p, const Vector3<F>& w) {
  const LocalDirection<F> local = to_local({p.tangent, p.bitangent}, p.normal, w);
  const F side = dot(p.geometric_normal, w), cosine = local.z;
  const F on_base = dot(p.base_normal, w);
  const auto reflects = cosine > 0.0f && side > 0.0f;
  const F cos_w = size_of_cosine(cosine), cos_base = size_of_cosine(on_base);

  ScatterValue<F> value;
  value.cosine = on_base;
  const HalfVector<F> half = half_vector(p.o, local, p.boundary.alpha);
  const F mirrored =
      eval_microfacet(half.density, p.o.z, p.boundary.root_o, cos_w, p.boundary.alpha);
  value.boundary_pdf = keep(cosine > 0.0f, microfacet_pdf(half.density, p.o.z, p.boundary.root_o));
  F below_coat = broadcast<F>(1.0f);
  value.coat = {F{}, F{}, F{}};
  value.coat_pdf = F{};
  if (p.coat_table != nullptr) {
    const RoughBoundary<F>& coat = p.coat_boundary;
    const LocalDirection<F> on_coat = to_local(p.coat_axes, p.coat_normal, w);
    const F cos_coat = size_of_cosine(on_coat.z);
    const HalfVector<F> coat_half = half_vector(p.coat_o, on_coat, coat.alpha);
    const F of_coat =
        p.coat * eval_microfacet(coat_half.density, p.coat_o.z, coat.root_o, cos_coat, coat.alpha);
    value.coat = mueller_of(fresnel_dielectric(coat_half.cosine, broadcast<F>(coat_ior))) *
                 keep(on_coat.z > 0.0f && side > 0.0f, of_coat);
    value.coat_pdf =
        keep(on_coat.z > 0.0f, microfacet_pdf(coat_half.density, p.coat_o.z, coat.root_o));
    below_coat = 1.0f - p.coat * eval_albedo(p.coat_table, coat.row, cos_coat);
  }
  const F diffuse = p.diffuse * inverse_pi * eval_entering(p, cos_base, w) * cos_base;
  value.diffuse_reflection = keep(on_base > 0.0f && side > 0.0f, diffuse);
  value.diffuse_transmission = keep(on_base < 0.0f && side < 0.0f, diffuse);
  const F of_mirrors = keep(reflects, below_coat * mirrored);
  value.dielectric =
      mueller_of(fresnel_dielectric(half.cosine, p.ior)) * (p.dielectric * of_mirrors);
  value.metal = p.metal * of_mirrors;
  value.half_cosine = half.cosine;
  return value;
}

// Per sr, of what sample_scatter gives for the lobe; 0 of what goes straight.
template <typename F, typename I>
OMMA_HD F pdf_scatter(I lobe, const ScatterValue<F>& value) {
  const auto is = [&](Lobe one) { return lobe == static_cast<std::int32_t>(one); };
  F pdf = keep(is(Lobe::diffuse_reflection), cosine_pdf(value.cosine));
  pdf = is(Lobe::diffuse_transmission) ? cosine_pdf(-value.cosine) : pdf;
  pdf = is(Lobe::dielectric) || is(Lobe::metal) ? value.boundary_pdf : pdf;
  return is(Lobe::coat) ? value.coat_pdf : pdf;
}
template <typename F, typename I>
OMMA_HD F pdf_scatter(I lobe, const ScatterPoint<F>& point, const Vector3<F>& w) {
  return pdf_scatter(lobe, eval_scatter(point, w));
}

// A direction of a lobe for two numbers in [0, 1), unit; eval_scatter may be 0 there.
template <typename F, typename I>
OMMA_HD Vector3<F> sample_scatter(I lobe, const ScatterPoint<F>& p, F u0, F u1) {
  const auto is = [&](Lobe one) { return lobe == static_cast<std::int32_t>(one); };
  const auto is_boundary = is(Lobe::dielectric) || is(Lobe::metal);
  LocalDirection<F> diffuse = sample_cosine(u0, u1), local = diffuse;
  diffuse.z = is(Lobe::diffuse_transmission) ? -diffuse.z : diffuse.z;
  const auto is_diffuse = is(Lobe::diffuse_reflection) || is(Lobe::diffuse_transmission);
  if (any_lane(is_boundary)) {
    const LocalDirection<F> d = sample_microfacet(p.o, p.boundary.alpha, u0, u1);
    local.x = is_boundary ? d.x : local.x;
    local.y = is_boundary ? d.y : local.y;
    local.z = is_boundary ? d.z : local.z;
  }
  Vector3<F> mirrored = from_local({p.tangent, p.bitangent}, p.normal, local);
  if (p.coat_table != nullptr) {
    const LocalDirection<F> d = sample_microfacet(p.coat_o, p.coat_boundary.alpha, u0, u1);
    mirrored = select(is(Lobe::coat), from_local(p.coat_axes, p.coat_normal, d), mirrored);
  }
  const Vector3<F> scattered = from_local(make_axes(p.base_normal), p.base_normal, diffuse);
  return select(is(Lobe::straight), p.direction, select(is_diffuse, scattered, mirrored));
}

// What a metal reflects in a band, over what its facets would if they were white and hid each other
// only: f0 is its colour at normal incidence.
template <typename F>
OMMA_HD F metal_color(F f0, F schlick, F gain) {
  return (f0 + (1.0f - f0) * schlick) * (1.0f + f0 * gain);
}

// Means over bands of what colours the lobes.
template <typename F>
struct LobeColors {
  F reflectance, transmittance;  // of the base, as it goes through a sheet diffusely
  F metal;                       // at normal incidence
  F straight;
};

// Made to add up to 1, or to 0 where nothing has a weight.
template <typename F>
OMMA_HD void scale_to_one(F (&weight)[lobe_count]) {
  F sum = weight[0];
  for (int k = 1; k < lobe_count; ++k) sum = sum + weight[k];
  const F scale = keep(sum > 0.0f, 1.0f / (sum > 0.0f ? sum : broadcast<F>(1.0f)));
  for (F& x : weight) x = x * scale;
}

// Probabilities of the lobes, about as much as each gives back of uniform light; they add up to 1,
// or to 0 where nothing comes back.
template <typename F>
OMMA_HD void lobe_weights(const ScatterPoint<F>& p, const LobeColors<F>& colors,
                          F (&weight)[lobe_count]) {
  const F base = p.base * 3.14159265f;
  weight[0] = base * colors.reflectance;
  weight[1] = base * colors.transmittance;
  weight[2] = p.dielectric_albedo;
  weight[3] = p.metal * metal_color(colors.metal, schlick_weight(p.o.z), p.metal_gain);
  weight[4] = p.straight * colors.straight;
  weight[5] = p.coat_albedo;
  scale_to_one(weight);
}

template <typename F>
struct LobeChoice {
  decltype(to_int(F{})) lobe;
  F probability;  // 0: none
};

// `u` in [0, 1).
template <typename F>
OMMA_HD LobeChoice<F> choose_lobe(const F (&weight)[lobe_count], F u) {
  LobeChoice<F> choice{to_int(F{}), F{}};
  F below = F{};
  for (int k = 0; k < lobe_count; ++k) {
    // The last that u has reached; one of no weight is never it, nor is one that rounding lost.
    const auto is_it = weight[k] > 0.0f && u >= below;
    choice.lobe = is_it ? choice.lobe * 0 + k : choice.lobe;
    choice.probability = is_it ? weight[k] : choice.probability;
    below = below + weight[k];
  }
  return choice;
}

}  // namespace omma
