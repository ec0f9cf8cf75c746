// The ground truth of a call: sizes of outputs and motions checked, tables by instance made.
#include "render/render_truth.h"

#include <cmath>
#include <span>
#include <string>

#include "omma/error.h"

namespace omma {
namespace {

// So that flow past what lies as near as least_distance_m stays in single precision.
constexpr double most_velocity = 1e9;

void check_velocities(const char* name, std::span<const Velocity> velocities, std::size_t expected,
                      const char* shape) {
  if (velocities.size() != expected)
    throw Error(std::string(name) + ": expected " + std::to_string(expected) + " velocities (" +
                shape + "), found " + std::to_string(velocities.size()));
  for (std::size_t i = 0; i < velocities.size(); ++i) {
    const Velocity& v = velocities[i];
    for (const double x : {v.linear_m_s.x, v.linear_m_s.y, v.linear_m_s.z, v.angular_rad_s.x,
                           v.angular_rad_s.y, v.angular_rad_s.z})
      if (!(std::fabs(x) <= most_velocity))
        throw Error(std::string(name) + "[" + std::to_string(i) +
                    "]: expected components of at most 1e9 m/s or rad/s, found " +
                    std::to_string(x));
  }
}

// Calls put(instance of the scene) for all that belong to an instance of the world.
template <typename Put>
void for_each_part(const BuiltScene& built, std::size_t thing, const Put& put) {
  for (int part = built.things.first[thing]; part < built.things.first[thing + 1]; ++part)
    put(static_cast<std::size_t>(built.things.instance[static_cast<std::size_t>(part)]));
}

// Clouds of splats stand behind the instances. One element at least, which vector loops read where
// nothing was met.
std::vector<std::int32_t> table_of_instances(const BuiltScene& built) {
  const std::size_t count = built.scene->instances.size() + built.scene->splats.size();
  return std::vector<std::int32_t>(std::max<std::size_t>(count, 1), -1);
}

void take_shares(const TruthCall& call, const BuiltScene& built, Truth& truth) {
  if (call.share_count < 0 || call.share_count > most_shares)
    throw Error("share_count: expected 0 to " + std::to_string(most_shares) + ", found " +
                std::to_string(call.share_count));
  const std::size_t things = built.things.count(), clouds = built.scene->splats.size();
  if (call.share_of_instance.size() != things + clouds)
    throw Error("share_of_instance: expected a group for each of " + std::to_string(things) +
                " instances" +
                (clouds > 0 ? " and " + std::to_string(clouds) + " clouds of splats" : "") +
                ", found " + std::to_string(call.share_of_instance.size()));
  truth.share_of_instance = table_of_instances(built);
  for (std::size_t thing = 0; thing < things + clouds; ++thing) {
    const std::int32_t group = call.share_of_instance[thing];
    if (group < -1 || group >= call.share_count)
      throw Error("share_of_instance[" + std::to_string(thing) + "]: expected -1 to " +
                  std::to_string(call.share_count - 1) + ", found " + std::to_string(group));
    if (thing < things)
      for_each_part(built, thing, [&](std::size_t i) { truth.share_of_instance[i] = group; });
    else
      truth.share_of_instance[built.scene->instances.size() + thing - things] = group;
  }
  truth.view.shares = call.share_count;
  truth.view.share_of_instance = truth.share_of_instance.data();
  truth.view.instance_count = static_cast<std::int32_t>(truth.share_of_instance.size());
}

void take_objects(const TruthCall& call, const BuiltScene& built, std::size_t poses, Truth& truth) {
  const std::size_t count = call.moving.size();
  check_velocities("objects", call.objects, poses * count, "pose x object");
  truth.object_of_instance = table_of_instances(built);
  std::vector<Vec3d> place(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto thing = static_cast<std::size_t>(call.moving[k]);  // what is below 0 is large
    if (thing >= built.things.count())
      throw Error("moving[" + std::to_string(k) + "]: expected an index into the " +
                  std::to_string(built.things.count()) + " instances of the world, found " +
                  std::to_string(call.moving[k]));
    for_each_part(built, thing, [&](std::size_t i) {
      if (truth.object_of_instance[i] >= 0)
        throw Error("moving[" + std::to_string(k) + "]: " + std::to_string(thing) +
                    " is there twice");
      truth.object_of_instance[i] = static_cast<std::int32_t>(k);
    });
    const auto& m = built.placement.world_from_mesh[first_instance(built, thing)].m;
    place[k] = Vec3d{m[0][3], m[1][3], m[2][3]} - built.placement.origin_m;
  }
  for (std::size_t i = 0; i < poses * count; ++i) {
    const Velocity& v = call.objects[i];
    for (const Vec3d& x : {place[i % count], v.linear_m_s, v.angular_rad_s})
      for (const double value : {x.x, x.y, x.z}) truth.objects.push_back(static_cast<float>(value));
  }
  truth.view.object_of_instance = truth.object_of_instance.data();
  truth.view.instance_count = static_cast<std::int32_t>(truth.object_of_instance.size());
  truth.view.object_count = static_cast<std::int32_t>(count);
}

}  // namespace

Truth checked_truth(const TruthCall& call, const BuiltScene& built, std::size_t poses,
                    std::size_t ommatidia) {
  Truth truth;
  bool is_asked = false;
  // Whether an output is asked for; if so its size must fit all poses.
  const auto asks = [&](const char* name, const auto& output, std::size_t each, const char* shape) {
    if (output.empty()) return false;
    const std::size_t expected = poses * ommatidia * each;
    if (output.size() != expected)
      throw Error(std::string(name) + ": expected room for " + std::to_string(expected) +
                  " values (" + shape + "), found " + std::to_string(output.size()));
    return is_asked = true;
  };
  const char* one = "pose x ommatidium";
  asks("distance_m", call.distance_m, 1, one);
  asks("nearest_m", call.nearest_m, 1, one);
  asks("inverse_distance_per_m", call.inverse_distance_per_m, 1, one);
  asks("met", call.met, 1, one);
  truth.view.sources = asks("source_distance_m", call.source_distance_m, 1, one);
  const char* vector = "pose x ommatidium x axis";
  truth.view.places = asks("position_m", call.position_m, 3, vector);
  truth.view.places = asks("normal", call.normal, 3, vector) || truth.view.places;
  const char* flow = "pose x ommatidium x (right, up)";
  for (const auto& [name, output] : {std::pair{"flow_rotation", call.flow_rotation},
                                   {"flow_translation", call.flow_translation},
                                   {"flow_objects", call.flow_objects}})
    truth.view.flow = asks(name, output, 2, flow) || truth.view.flow;
  if (asks("shares", call.shares, static_cast<std::size_t>(call.share_count),
           "pose x ommatidium x group"))
    take_shares(call, built, truth);
  if (!is_asked) return truth;

  if (!call.head.empty()) check_velocities("head", call.head, poses, "pose");
  if (truth.view.flow && !call.moving.empty()) take_objects(call, built, poses, truth);
  const Vec3d origin = built.placement.origin_m;
  for (std::size_t p = 0; p < poses; ++p) {
    TruthTask task;
    const auto of_pose = [&](const auto& output, std::size_t each) {
      return output.empty() ? nullptr : output.data() + p * ommatidia * each;
    };
    const auto set = [](auto& to, const Vec3d& v) {
      to[0] = static_cast<std::remove_reference_t<decltype(to[0])>>(v.x);
      to[1] = static_cast<std::remove_reference_t<decltype(to[0])>>(v.y);
      to[2] = static_cast<std::remove_reference_t<decltype(to[0])>>(v.z);
    };
    set(task.origin_m, origin);
    if (!call.head.empty()) {
      set(task.linear_m_s, call.head[p].linear_m_s);
      set(task.angular_rad_s, call.head[p].angular_rad_s);
    }
    task.objects = truth.objects.data() + p * call.moving.size() * 9;
    task.distance_m = of_pose(call.distance_m, 1);
    task.nearest_m = of_pose(call.nearest_m, 1);
    task.inverse_distance_per_m = of_pose(call.inverse_distance_per_m, 1);
    task.met = of_pose(call.met, 1);
    task.source_distance_m = of_pose(call.source_distance_m, 1);
    task.position_m = of_pose(call.position_m, 3);
    task.normal = of_pose(call.normal, 3);
    task.shares = of_pose(call.shares, static_cast<std::size_t>(call.share_count));
    task.flow_rotation = of_pose(call.flow_rotation, 2);
    task.flow_translation = of_pose(call.flow_translation, 2);
    task.flow_objects = of_pose(call.flow_objects, 2);
    truth.tasks.push_back(task);
  }
  return truth;
}

}  // namespace omma
