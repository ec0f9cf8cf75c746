// Copies of all arrays of a view in other memory, their bytes, and whether two views' are the same:
// what follows from the table of view_arrays.h.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <initializer_list>
#include <map>
#include <set>
#include <type_traits>
#include <utility>
#include <vector>

#include "backend/view_arrays.h"

namespace omma {

// As the comment of an array has it, [a][b][c].
using ArrayShape = std::initializer_list<std::int64_t>;

inline std::size_t size_of(ArrayShape shape) {
  std::size_t size = 1;
  for (const std::int64_t n : shape) size *= static_cast<std::size_t>(n);
  return size;
}

// Points views to copies of their arrays, of views within them too. What several have in common, as
// the tasks of a pose its responses, is copied once: it is known by where it is, so that all stays
// there while this lives. Views that hold arrays are put together here before they are copied, so
// that the copies may lie where the host cannot write.
//
// `Copy` makes them: read(array, count, version) gives where a copy is, which may be one that was
// kept of that version; written(array, count) where one is that is written to, of which some is
// added to. Neither is null, whatever the count; null stays null.
template <typename Copy>
class ArrayCopies {
 public:
  explicit ArrayCopies(Copy& copy) : copy_(copy) {}

  Version version = 0;  // of what is visited

  // `more`: what visit_arrays asks for besides.
  template <typename View, typename... More>
  void point_to_copies(View& view, const More&... more) {
    visit_arrays(view, *this, more...);
  }

  template <typename T>
  void operator()(const T*& array, ArrayShape shape) {
    (*this)(array, shape, version);
  }
  template <typename T>
  void operator()(const T*& array, ArrayShape shape, Version own) {
    const std::size_t count = size_of(shape);
    point(array, count, [&] { return copy_.read(array, count, own); });
  }

  template <typename T>
  requires(!std::is_const_v<T>) void operator()(T*& array, ArrayShape shape) {
    const std::size_t count = size_of(shape);
    point(array, count, [&] { return copy_.written(array, count); });
  }

  template <typename View, typename... More>
  void views(const View*& array, ArrayShape shape, const More&... more) {
    const std::size_t count = size_of(shape);
    point(array, count, [&] {
      std::vector<View> views(array, array + count);
      for (View& view : views) visit_arrays(view, *this, more...);
      return copy_.read(static_cast<const View*>(views.data()), count, Version{0});
    });
  }

 private:
  template <typename T, typename Make>
  void point(T*& array, std::size_t count, const Make& make) {
    static_assert(std::is_trivially_copyable_v<T>);
    if (array == nullptr) return;
    const std::pair key{static_cast<const void*>(array), count * sizeof(T)};
    const auto known = copied_.find(key);
    if (known != copied_.end()) {
      array = static_cast<T*>(const_cast<void*>(known->second));
      return;
    }
    array = make();
    copied_.emplace(key, array);
  }

  Copy& copy_;
  std::map<std::pair<const void*, std::size_t>, const void*> copied_;  // by place and bytes
};

// All arrays of a view, one after the other, of views within them too.
struct ArrayList {
  struct Entry {
    const void* array;  // or null
    std::size_t bytes;
    bool is_plain, is_written;  // plain: no views that hold arrays
  };
  std::vector<Entry> entries;
  Version version = 0;  // of what is visited; not asked for

  template <typename View, typename... More>
  static ArrayList of(View view, const More&... more) {
    ArrayList list;
    visit_arrays(view, list, more...);
    return list;
  }

  template <typename T>
  void operator()(T*& array, ArrayShape shape, Version = 0) {
    add(array, size_of(shape), true);
  }

  template <typename View, typename... More>
  void views(const View*& array, ArrayShape shape, const More&... more) {
    const std::size_t count = size_of(shape);
    add(array, count, false);
    for (std::size_t i = 0; array != nullptr && i < count; ++i) {
      View view = array[i];
      visit_arrays(view, *this, more...);
    }
  }

 private:
  template <typename T>
  void add(T* array, std::size_t count, bool is_plain) {
    entries.push_back(
        {array, array != nullptr ? count * sizeof(T) : 0, is_plain, !std::is_const_v<T>});
  }
};

// Of all arrays of a view, those that several views within it have in common once.
template <typename View, typename... More>
std::size_t bytes_of(const View& view, const More&... more) {
  std::set<std::pair<const void*, std::size_t>> known;
  std::size_t bytes = 0;
  for (const ArrayList::Entry& entry : ArrayList::of(view, more...).entries)
    if (known.emplace(entry.array, entry.bytes).second) bytes += entry.bytes;
  return bytes;
}

// Whether two views' arrays are there alike and hold the same bytes, what is written left out.
template <typename View, typename... More>
bool same_arrays(const View& a, const View& b, const More&... more) {
  const ArrayList of_a = ArrayList::of(a, more...), of_b = ArrayList::of(b, more...);
  if (of_a.entries.size() != of_b.entries.size()) return false;
  for (std::size_t i = 0; i < of_a.entries.size(); ++i) {
    const ArrayList::Entry &x = of_a.entries[i], &y = of_b.entries[i];
    if ((x.array == nullptr) != (y.array == nullptr) || x.bytes != y.bytes) return false;
    if (!x.is_plain || x.is_written || x.bytes == 0) continue;
    if (std::memcmp(x.array, y.array, x.bytes) != 0) return false;
  }
  return true;
}

}  // namespace omma
