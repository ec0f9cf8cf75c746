// A value that is made when first asked for and kept from then on. Threads that ask at the same
// time each make it, and one of theirs stays: so nobody waits for another, work that was cancelled
// leaves nothing behind, and there is no lock that a forked process may find held, as the one of a
// function's static variable would be.
#pragma once

#include <atomic>
#include <memory>

namespace omma {

template <typename T>
class MadeOnce {
 public:
  MadeOnce() = default;
  MadeOnce(const MadeOnce&) = delete;
  MadeOnce& operator=(const MadeOnce&) = delete;
  ~MadeOnce() { delete made_.load(); }

  // The value; make() returns it where it is not there yet.
  template <typename Make>
  const T& get(const Make& make) {
    const T* made = made_.load();
    if (made != nullptr) return *made;
    auto mine = std::make_unique<const T>(make());
    if (!made_.compare_exchange_strong(made, mine.get())) return *made;
    return *mine.release();
  }

 private:
  std::atomic<const T*> made_ = nullptr;
};

}  // namespace omma
