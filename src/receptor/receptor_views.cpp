// The views of an eye's receptors.
#include "omma/receptor_views.h"

#include <cmath>
#include <string>

#include "omma/error.h"
#include "threads/cancel.h"

namespace omma {
namespace {

bool looks_with_ommatidium(const ReceptorType& type) {
  return type.right_rad == 0 && type.up_rad == 0 && !type.acceptance;
}

bool look_alike(const ReceptorType& a, const ReceptorType& b) {
  return a.right_rad == b.right_rad && a.up_rad == b.up_rad && a.acceptance == b.acceptance;
}

// Turns the frame of ommatidium i by the offset: along the great circle from its axis that leaves
// in the offset's direction, as far as the offset is long.
void turn(const Eye& eye, std::size_t i, const ReceptorType& type, Vec3& axis, Vec3& up) {
  const double angle = std::hypot(type.right_rad, type.up_rad);
  const Vec3d a = normalize(to_double(eye.axis[i])), u = normalize(to_double(eye.up[i]));
  const Vec3d side = cross(a, u) * (type.right_rad / angle) + u * (type.up_rad / angle);
  const double c = std::cos(angle), s = std::sin(angle);
  // The part of up along `side` goes with it, the rest stays.
  const double along = type.up_rad / angle;
  axis = to_float(normalize(a * c + side * s));
  up = to_float(normalize(u + side * (along * (c - 1)) - a * (along * s)));
}

// What a view is made of: an ommatidium, and the receptor that sees beside its axis or with an
// acceptance of its own, or null.
struct ViewPlan {
  std::vector<std::int64_t> ommatidium;     // [view]
  std::vector<const ReceptorType*> type;    // [view]
  std::vector<std::int32_t> acceptance_of;  // [view], index into the views' acceptances; -1: own

  void add(std::size_t i, const ReceptorType* of_type, std::int32_t acceptance) {
    ommatidium.push_back(static_cast<std::int64_t>(i));
    type.push_back(of_type);
    acceptance_of.push_back(acceptance);
  }
};

// `acceptances`: the eye's, with those of receptors behind.
Eye make_views(const Eye& eye, std::vector<Acceptance> acceptances, const ViewPlan& plan) {
  Eye bare = eye;
  bare.receptor_types.clear();
  bare.receptor_type.clear();
  bare.first_receptor.clear();
  bare.columns.clear();
  validate_eye(bare);
  Eye views = take_ommatidia(bare, plan.ommatidium);
  views.acceptances = std::move(acceptances);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const ReceptorType* type = plan.type[v];
    if (type != nullptr && (type->right_rad != 0 || type->up_rad != 0))
      turn(eye, static_cast<std::size_t>(plan.ommatidium[v]), *type, views.axis[v], views.up[v]);
    if (plan.acceptance_of[v] < 0) continue;
    views.acceptance_of[v] = plan.acceptance_of[v];
    views.acceptance_angle_rad[v] = 0;  // its mean width, found when validated
  }
  validate_eye(views);
  return views;
}

}  // namespace

ReceptorViews receptor_views(const Eye& eye) {
  const std::string name = eye.path.empty() ? "eye" : eye.path;
  if (eye.receptor_type.empty())
    throw Error(name + ": expected ommatidia with receptors, found none (Eye's receptor_types)");
  ReceptorViews views;
  ViewPlan plan;
  std::vector<Acceptance> acceptances = eye.acceptances;
  views.view_of_receptor.resize(eye.receptor_type.size());
  // A type's own acceptance is listed once behind those of the eye, and types that look the same
  // way are one.
  const std::size_t types = eye.receptor_types.size();
  std::vector<std::size_t> way(types);
  std::vector<std::int32_t> acceptance(types, -1);
  for (std::size_t t = 0; t < types; ++t) {
    check_cancelled();
    const ReceptorType& type = eye.receptor_types[t];
    way[t] = 0;
    while (!look_alike(eye.receptor_types[way[t]], type)) ++way[t];
    if (!type.acceptance) continue;
    if (way[t] < t) {
      acceptance[t] = acceptance[way[t]];
      continue;
    }
    acceptance[t] = static_cast<std::int32_t>(acceptances.size());
    acceptances.push_back(*type.acceptance);
  }
  bool plain = false;
  for (const std::int32_t t : eye.receptor_type)
    plain = plain || looks_with_ommatidium(eye.receptor_types[static_cast<std::size_t>(t)]);
  if (plain)
    for (std::size_t i = 0; i < eye.size(); ++i) plan.add(i, nullptr, -1);
  for (std::size_t i = 0; i < eye.size(); ++i) {
    check_cancelled();
    const auto first = static_cast<std::size_t>(eye.first_receptor[i]);
    const auto end = static_cast<std::size_t>(eye.first_receptor[i + 1]);
    for (std::size_t r = first; r < end; ++r) {
      const auto t = static_cast<std::size_t>(eye.receptor_type[r]);
      const ReceptorType& type = eye.receptor_types[t];
      if (looks_with_ommatidium(type)) {
        views.view_of_receptor[r] = static_cast<std::int32_t>(i);
        continue;
      }
      std::size_t same = first;
      while (same < r && way[static_cast<std::size_t>(eye.receptor_type[same])] != way[t]) ++same;
      if (same < r) {
        views.view_of_receptor[r] = views.view_of_receptor[same];
        continue;
      }
      views.view_of_receptor[r] = static_cast<std::int32_t>(plan.type.size());
      plan.add(i, &type, acceptance[t]);
    }
  }
  views.eye = make_views(eye, std::move(acceptances), plan);
  return views;
}

}  // namespace omma
