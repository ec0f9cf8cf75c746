// What the threads of a grid do: the kernels of a graphics card, written over a Grid that says
// which threads there are. Each thread takes an ommatidium (thread.h), of whatever task it is; of
// tasks to an error a block takes one after the other, as its ommatidia listen to each other.
//
// A Grid has
//
//   first(), step()        index of the first task that this block takes, and from one to the next
//   for_each(count, each)  each(i) for all i < count <= most_per_block, by a thread each; all are
//                          done when it returns
//   once(ask)              what ask() says, an int, for all threads; one of them asks
//   block_memory()         of this block: GridLaunch::block_bytes, then thread_bytes of each thread
#pragma once

#include "physics/block/thread.h"
#include "physics/block/weigh.h"
#include "physics/path/gather.h"
#include "physics/surface/scene_search.h"
#include "physics/views/grid_launch.h"

namespace omma {

// Lanes of a thread that gathers light: the paths of a receiver take over points of each other, so
// it has a whole packet.
using GatherPackets = Lanes<packet_rays, 1>;

template <typename Grid>
OMMA_HD std::byte* thread_memory(const GridLaunch& launch, Grid& grid, int i) {
  return grid.block_memory() + launch.block_bytes +
         static_cast<std::size_t>(i) * launch.thread_bytes;
}

// A launch's own packets or tasks that are taken most_per_block at a time, `each` by a thread.
template <typename Grid, typename Each>
OMMA_HD void for_each_of(std::int64_t count, Grid& grid, const Each& each) {
  for (std::int64_t k = grid.first() * most_per_block; k < count;
       k += grid.step() * most_per_block) {
    const std::int64_t left = count - k;
    grid.for_each(left < most_per_block ? static_cast<int>(left) : most_per_block,
                  [&](int i) { each(k + i, i); });
  }
}

// Calls `run(what an ommatidium is rendered with, its number in the task)` for all of all tasks.
template <typename Grid, typename Run>
OMMA_HD void for_each_ommatidium(const GridLaunch& launch, Grid& grid, const Run& run) {
  const auto* tasks = static_cast<const BlockTask*>(launch.tasks);
  const std::int64_t each = launch.threads_each;
  for_each_of(launch.count * each, grid, [&](std::int64_t k, int i) {
    const FrameView& frame = *launch.frame;
    const BlockTask& task = tasks[k / each];
    const auto member = static_cast<int>(k % each);
    if (member >= task.count) return;  // the last task of a pose may have fewer
    const BlockMemory& memory = lay_out_thread(thread_memory(launch, grid, i), frame);
    SceneSearch<OneLane> search{launch.searched, launch.bvh, memory.visits};
    run(BlockRun<SceneSearch<OneLane>>{frame, task, search, memory}, member);
  });
}

// A task to an error: rounds of rays, between which one thread chooses who needs more. Those are
// taken by the first threads of the block, so that of the others whole warps rest.
template <typename Grid>
OMMA_HD void render_task_to_error(const GridLaunch& launch, Grid& grid, const BlockTask& task) {
  const FrameView& frame = *launch.frame;
  Scratch of_block{grid.block_memory()};
  const ErrorMemory known = lay_out_error(of_block, frame);
  const auto run_as = [&](int thread, int member, const auto& run) {
    BlockMemory& memory = lay_out_thread(thread_memory(launch, grid, thread), frame);
    share_error(frame, known, member, memory);
    SceneSearch<OneLane> search{launch.searched, launch.bvh, memory.visits};
    run(BlockRun<SceneSearch<OneLane>>{frame, task, search, memory});
  };
  int count = grid.once([&] {
    begin_error(frame, task, known);
    return list_members(task, known, 1);
  });
  for (int scramble = 0; count > 0; ++scramble) {
    grid.for_each(count, [&](int i) {
      const std::int32_t member = known.members[i];
      run_as(i, member, [&](const auto& run) {
        trace_members<OneLane>(run, {known.next[member], scramble}, &member, 1);
      });
    });
    count = grid.once(
        [&] { return list_members(task, known, choose_rounds(frame, task, known)); });
  }
  grid.for_each(task.count, [&](int i) {
    run_as(i, i, [&](const auto& run) { end_error_of_ommatidium(run, i); });
  });
}

template <typename Grid>
OMMA_HD void render_tasks(const GridLaunch& launch, Grid& grid) {
  const auto* tasks = static_cast<const BlockTask*>(launch.tasks);
  if (launch.frame->most_samples > 0)
    for (std::int64_t k = grid.first(); k < launch.count; k += grid.step())
      render_task_to_error(launch, grid, tasks[k]);
  else
    for_each_ommatidium(launch, grid, [](const auto& run, int i) { render_ommatidium(run, i); });
}

// Adds what ommatidia see of discs of the sky to their responses.
template <typename Grid>
OMMA_HD void render_discs_of_tasks(const GridLaunch& launch, Grid& grid) {
  for_each_ommatidium(launch, grid,
                      [](const auto& run, int i) { render_discs_of_ommatidium(run, i); });
}

// Light that is baked: a task a thread.
template <typename Grid>
OMMA_HD void gather_tasks(const GridLaunch& launch, Grid& grid) {
  const auto* tasks = static_cast<const GatherTask*>(launch.tasks);
  for_each_of(launch.count, grid, [&](std::int64_t k, int i) {
    SceneSearch<GatherPackets> search{launch.searched, launch.bvh};
    Scratch scratch{thread_memory(launch, grid, i)};
    const BlockMemory memory = lay_out(scratch, *launch.frame, packet_rays);
    gather_light<GatherPackets>(*launch.frame->scene, search, tasks[k], memory.paths,
                                memory.radiance);
  });
}

// Rays that ommatidia share into responses: an ommatidium of a frame a thread.
template <typename Grid>
OMMA_HD void weigh_tasks(const GridLaunch& launch, Grid& grid) {
  const auto* tasks = static_cast<const WeighTask*>(launch.tasks);
  const std::int64_t ommatidia = launch.shared->ommatidium_count;
  for_each_of(launch.count * ommatidia, grid, [&](std::int64_t k, int) {
    const WeighTask& task = tasks[k / ommatidia];
    const std::int64_t o = k % ommatidia;
    weigh_rays<Lanes<weight_group, 1>>(*launch.shared, task.radiance, launch.outputs, o, o + 1,
                                       task.responses);
  });
}

// Closest accepted hits of the rays of packets, written into them: a ray a thread.
template <typename Grid>
OMMA_HD void find_closest(const GridLaunch& launch, Grid& grid) {
  auto* packets = static_cast<RayPacket<packet_rays>*>(const_cast<void*>(launch.tasks));
  for_each_of(launch.count * packet_rays, grid, [&](std::int64_t k, int i) {
    Scratch scratch{thread_memory(launch, grid, i)};
    const SceneSearch<OneLane> search{launch.searched, launch.bvh, lay_out_visits(scratch)};
    RayPacket<packet_rays>& packet = packets[k / packet_rays];
    const auto l = static_cast<int>(k % packet_rays);
    RayPacket<1> ray;
    clear<OneLane>(ray);
    for (int a = 0; a < 3; ++a) {
      ray.origin[a][0] = packet.origin[a][l];
      ray.direction[a][0] = packet.direction[a][l];
    }
    ray.t_near_m[0] = packet.t_near_m[l];
    ray.t_far_m[0] = packet.t_far_m[l];
    ray.mask[0] = packet.mask[l];
    ray.geometry[0] = ray.instance[0] = none;
    search.closest(LaneMask<OneLane>::all(), ray, nullptr);
    for (int a = 0; a < 3; ++a) packet.normal[a][l] = ray.normal[a][0];
    packet.t_far_m[l] = ray.t_far_m[0];
    packet.u[l] = ray.u[0];
    packet.v[l] = ray.v[0];
    packet.triangle[l] = ray.triangle[0];
    packet.geometry[l] = ray.geometry[0];
    packet.instance[l] = ray.instance[0];
  });
}

}  // namespace omma
