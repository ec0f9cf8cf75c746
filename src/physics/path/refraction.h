// Boundaries of volumes (media.h) on lit paths: how rays from the eye bend there and are mirrored
// within, and what volumes take of the light on the way.
#pragma once

#include "physics/path/flight.h"
#include "physics/path/media.h"
#include "physics/path/scattered.h"
#include "physics/rays/hits.h"
#include "physics/surface/lit_surface.h"

namespace omma {

// What is different of surfaces that bound volumes, of lanes from l on. From within they reflect as
// from outside at the angle by which the ray would leave: rays from the eye and those that begin
// there. What rays from the eye have of that is theirs alone (refract_rays), not sampled of lights.
template <typename L, typename Search>
OMMA_HD_CALLED void make_boundary_point(const Flight<L, Search>& flight,
                                        const LitSurface<L>& surface, int l,
                                        ScatteringPacket<L>& scattering) {
  using F = typename L::F;
  using I = typename L::I;
  const I volume = load<I>(surface.volume + l);
  const auto is_met = load<I>(surface.material + l) >= 0;
  const auto enters = is_met && volume > 0, leaves = is_met && volume < 0;
  if (!any_lane(enters || leaves)) return;
  ScatterPoint<F>& point = scattering.point[l / L::width];
  const F one = broadcast<F>(1.0f);
  const F density = flight.state.gathers ? F{} : load<F>(flight.state.density + l);
  const auto bends = !(density < INFINITY) && (enters || leaves);
  scattering.bends.bits |= lane_bits(bends) << l;
  const auto within = leaves && (bends || has_come<L>(flight.memory.media, l, Came::from_within));
  if (any_lane(within)) {
    const F n = load<F>(surface.ior + l);
    const F cos_2 = one - n * n * (one - point.o.z * point.o.z);
    const F cosine = sqrt_lanes(cos_2 > 0.0f ? cos_2 : F{});
    const auto is_total = !(cos_2 > 0.0f);
    const F albedo =
        point.dielectric *
        (is_total ? one : eval_albedo(point.albedo_tables, point.boundary.row, cosine));
    // Of what gets through, the part that the base scatters.
    const F let_in = one - point.dielectric_albedo;
    const F more = (one - albedo) / (let_in > 1e-3f ? let_in : broadcast<F>(1e-3f));
    point.base = within ? point.base * more : point.base;
    point.diffuse = within ? point.diffuse * more : point.diffuse;
    point.ior = within ? one / n : point.ior;
    point.dielectric_albedo = within ? albedo : point.dielectric_albedo;
    point.straight = within && bends ? load<F>(surface.transmission + l) : point.straight;
    // Rays that begin within are mirrored as by a smooth boundary, and as much as by this one:
    // facets would lose light that is mirrored more than once.
    const F smooth = mueller_of(fresnel_dielectric(point.o.z, one / n)).a;
    const auto is_mirror = within && !bends && point.boundary.alpha > microfacet_alpha(F{});
    point.boundary.alpha = is_mirror ? microfacet_alpha(F{}) : point.boundary.alpha;
    point.dielectric =
        is_mirror ? albedo / (smooth > 1e-6f ? smooth : broadcast<F>(1e-6f)) : point.dielectric;
    point.dielectric = within && bends ? F{} : point.dielectric;
  }
  const F scale = radiance_scale(surface, flight.memory.media, l, scattering.bends);
  point.straight = point.straight * (enters || leaves ? scale : one);
}

// The normals of facets that viewers see, of lanes from l on: those of rough boundaries by chance,
// else the surface's own.
template <typename L, typename Search>
OMMA_HD Vector3<typename L::F> sample_facets(const Flight<L, Search>& flight,
                                             const ScatterPoint<typename L::F>& p, int l) {
  using F = typename L::F;
  const auto is_rough = p.boundary.alpha > microfacet_alpha(F{});
  if (!any_lane(is_rough)) return p.normal;
  const auto place = choose<L>(flight.packet, flight.state, l, Choice::direction);
  const LocalDirection<F> w = sample_microfacet(p.o, p.boundary.alpha, place.x, place.y);
  const LocalDirection<F> half{p.o.x + w.x, p.o.y + w.y, p.o.z + w.z};
  return select(is_rough, normalize(from_local({p.tangent, p.bitangent}, p.normal, half)),
                p.normal);
}

// Rays from the eye at boundaries of volumes. What goes into one bends by Snell's law,
//
//   t = d / η + (cos θ / η - cos θ') n,   sin θ' = sin θ / η,   η = n' / n
//
// (Born and Wolf 1999, 1.5.1). What comes from within does so or is mirrored, by chance as often as
// Fresnel says. Both stay rays from the eye, by a Mueller matrix of their own; light that gets
// through is what is not reflected of each polarisation.
template <typename L, typename Search>
OMMA_HD_CALLED void refract_rays(const Flight<L, Search>& flight, const ScatteringPacket<L>& points,
                                 ScatteringSample<L>& sample) {
  using F = typename L::F;
  using I = typename L::I;
  for (int l = 0; l < L::count; l += L::width) {
    const ScatterPoint<F>& p = points.point[l / L::width];
    const F(&weight)[lobe_count] = points.weight[l / L::width];
    const I lobe = load<I>(sample.lobe + l);
    const auto is = [&](Lobe one) { return lobe == static_cast<std::int32_t>(one); };
    const auto is_within = p.ior < 1.0f;
    const auto is_asked =
        points.bends.at(l) && (is(Lobe::straight) || (is(Lobe::dielectric) && is_within));
    if (!any_lane(is_asked)) continue;

    const Vector3<F> d = p.direction;
    Vector3<F> n = sample_facets(flight, p, l);
    const F one = broadcast<F>(1.0f), per_ior = one / p.ior;
    const F chance = choose<L>(flight.packet, flight.state, l, Choice::light).x;
    F cosine, cos_2, side;
    Vector3<F> bent, mirrored;
    Mueller<F> mirror;
    Amplitudes<F> r;
    auto reflects = is_asked && is_within;
    const auto turn = [&]() __attribute__((always_inline)) {
      cosine = size_of_cosine(dot(d, n));
      cos_2 = one - (one - cosine * cosine) * (per_ior * per_ior);
      const F beyond = sqrt_lanes(cos_2 > 0.0f ? cos_2 : F{});
      bent = normalize(d * per_ior + n * (cosine * per_ior - beyond));
      mirrored = normalize(d + n * (2.0f * cosine));
      r = fresnel_dielectric(cosine, p.ior);
      mirror = mueller_of(r);
      reflects = is_asked && is_within && (chance < mirror.a || !(cos_2 > 0.0f));
      side = dot(select(reflects, mirrored, bent), p.geometric_normal);
      return is_asked && (reflects ? side : 0.0f - side) <= 0.0f;
    };
    auto is_lost = turn();
    // What a facet sends to the wrong side meets others before it leaves: as from the surface's own
    // normal, so that nothing is lost.
    if (any_lane(is_lost)) {
      n = select(is_lost, p.normal, n);
      is_lost = turn();
    }
    const auto bends = is_asked && !reflects;

    const auto set = [&](float* at, auto which, F value) {
      store(at, which ? value : load<F>(at));
    };
    // From within, either lobe stands for both.
    const F both =
        weight[static_cast<int>(Lobe::straight)] + weight[static_cast<int>(Lobe::dielectric)];
    const F per_both = one / (both > 0.0f ? both : one);
    set(sample.by.reflected + l, is_asked && is_within, bends ? p.straight * per_both : F{});
    set(sample.by.dielectric[0] + l, is_asked, reflects ? per_both : F{});
    set(sample.by.half_cosine + l, reflects, cosine);
    // Of what is refracted the elements are over its first, which `reflected` has.
    const F s = one - r.s * r.s, q = one - r.p * r.p, sum = s + q, product = s * q;
    const F per_sum = one / (sum > 0.0f ? sum : one);
    const F per_a = per_both / (mirror.a > 0.0f ? mirror.a : one);
    set(sample.by.dielectric[1] + l, is_asked, reflects ? mirror.b * per_a : (s - q) * per_sum);
    set(sample.by.dielectric[2] + l, is_asked,
        reflects ? mirror.c * per_a : 2.0f * sqrt_lanes(product > 0.0f ? product : F{}) * per_sum);
    const Vector3<F> before = load_vector<F>(sample.direction, l);
    store_vector(sample.direction, l,
                 without_noise(select(bends, bent, select(reflects, mirrored, before))));
    set(sample.density + l, is_asked, broadcast<F>(INFINITY));
    set(flight.packet.acceptance_sr + l, is_asked, F{});  // they find discs of the sky themselves
    const I gone = lobe * 0 + no_lobe, on = lobe * 0 + refracted,
            back = lobe * 0 + static_cast<std::int32_t>(Lobe::dielectric);
    store(sample.lobe + l, is_lost ? gone : bends ? on : reflects ? back : lobe);
  }
}

// What volumes absorb of the light from what some lanes met.
template <typename L, typename Search>
OMMA_HD_CALLED void pass_media(const Flight<L, Search>& flight, const LitSurface<L>& surface,
                               LaneMask<L> met) {
  float part[L::count];
  for (float& all : part) all = 1;
  absorb(flight.scene, flight.memory.media, surface, {met, flight.packet.rays.t_far_m, part},
         flight.memory.throughput);
}

// Of paths that go straight out of a volume what it absorbs on the bent way, in its place.
template <typename L, typename Search>
OMMA_HD_CALLED void count_bent_way(const Flight<L, Search>& flight, const LitSurface<L>& surface,
                                   const ScatteringPacket<L>& points, LaneMask<L> straight) {
  const RayMedia& media = flight.memory.media;
  alignas(L::count * 4) float cosine[L::count];
  for (int l = 0; l < L::count; l += L::width) store(cosine + l, points.point[l / L::width].o.z);
  straight.for_each([&](int l) {
    const float* const absorption_per_m = absorption_before(flight.scene, media, surface, l);
    if (absorption_per_m == nullptr) return;
    const float way_m = flight.packet.rays.t_far_m[l] - media.from_m[l];
    const float bent_m = way_m * bent_way(media, surface, l, cosine[l]);
    for (int b = 0; b < flight.scene.bands; ++b)
      flight.memory.throughput[b * L::count + l] *=
          left_by_depth(absorption_per_m[b] * bent_m) / left_by_depth(absorption_per_m[b] * way_m);
  });
}

// What rays are in that go on: straight, bent, or scattered. Those that a base scatters begin
// there, on its other side where that is the lobe's.
template <typename L, typename Search>
OMMA_HD_CALLED void leave_media(const Flight<L, Search>& flight, const LitSurface<L>& surface,
                                const ScatteringSample<L>& sample, LaneMask<L> by, LaneMask<L> bent,
                                LaneMask<L> scattered) {
  const RayMedia& media = flight.memory.media;
  scattered.for_each([&](int l) {
    const auto is = [&](Lobe one) { return sample.lobe[l] == static_cast<std::int32_t>(one); };
    const std::int32_t volume = surface.volume[l];
    media.from_m[l] = 0;
    if (volume != 0 && (volume < 0) != is(Lobe::diffuse_transmission))
      media.material[l] = surface.material[l];
    else if (volume < 0)
      media.material[l] = no_medium;
    if (volume >= 0 || !is(Lobe::dielectric))
      set_came(media, l, Came::from_within);
    else if (media.came[l] != static_cast<std::int32_t>(Came::straight))
      set_came(media, l, Came::mirrored);
  });
  pass_boundaries(surface, by, bent, flight.packet.rays.t_far_m, media);
}

// The next rays of paths that were bent.
template <typename L, typename Search>
OMMA_HD_CALLED void bend_rays(const Flight<L, Search>& flight, LaneMask<L> bent,
                              const HitGeometry<L>& geometry, const ScatteringSample<L>& sample) {
  bent.for_each([&](int l) {
    flight.state.seen_m[l] = 0;
    flight.passed->count[l] = 0;
  });
  leave_surfaces<L>(geometry, sample.direction, bent, flight.packet.rays);
}

}  // namespace omma
