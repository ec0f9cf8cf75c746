// A thread that comes back to an interpreter which is ending never gets the GIL: up to Python 3.13
// it is ended there and then by pthread_exit, which must not unwind through the engine or nanobind,
// from 3.14 on it waits for ever (https://github.com/python/cpython/issues/87135). Therefore an
// atexit function, which runs while all is still well, cancels the work of all other threads and
// waits for them; who still comes too late waits for ever too.
#include "progress.h"

#include <atomic>
#include <chrono>
#include <exception>
#include <thread>

#include "model/long_work.h"
#include "omma/error.h"
#include "system/process.h"

namespace omma::python {

namespace nb = nanobind;

namespace {

// Threads of Python's that are in the engine, and those of them that are back in Python for a
// moment to call a progress callback. A thread may be in both several times, one inside the other.
std::atomic<int> in_engine = 0, in_callback = 0;
thread_local int own_in_engine = 0, own_in_callback = 0;

// Python is ending, and this is the thread that ends it.
std::atomic<bool> ending = false;
thread_local bool ends_python = false;

bool must_end() {
  return ending && !ends_python;
}

// In the child of a fork there are no other threads.
void forget_other_threads() {
  in_engine = own_in_engine;
  in_callback = own_in_callback;
}

void enter(std::atomic<int>& all, int& own) {
  ++all;
  ++own;
}

void leave(std::atomic<int>& all, int& own) {
  --own;
  --all;
}

[[noreturn]] void wait_for_ever() {
  for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
}

// Runs work(thread), where `thread` is what takes the GIL back.
template <typename Work>
void leave_python(const Work& work) {
  PyThreadState* const thread = PyEval_SaveThread();
  enter(in_engine, own_in_engine);
  std::exception_ptr failure;
  try {
    work(thread);
  } catch (const std::exception&) {
    failure = std::current_exception();
  } catch (...) {
    // pthread_exit, called while this thread was back in Python. All the work has ended on the way
    // here; the counts are those of a thread in a callback, for which nobody waits for long.
    wait_for_ever();
  }
  leave(in_engine, own_in_engine);
  try {
    PyEval_RestoreThread(thread);
  } catch (...) {  // pthread_exit
    wait_for_ever();
  }
  if (failure) std::rethrow_exception(failure);
}

// Back in Python for a moment: whether signals and `callback` let the work go on; if not, `raised`
// says why. Nothing here has a destructor that would need the GIL: where Python ends meanwhile,
// pthread_exit goes through.
bool ask_python(PyThreadState* thread, PyObject* callback, double done,
                std::exception_ptr& raised) {
  PyEval_RestoreThread(thread);
  bool goes_on = PyErr_CheckSignals() == 0;
  if (goes_on && callback != Py_None) {
    PyObject* const result = PyObject_CallFunction(callback, "d", done);
    goes_on = result != nullptr;
    Py_XDECREF(result);
  }
  if (!goes_on) {
    // It must not travel through the engine, so it waits until the work has stopped.
    try {
      nb::raise_python_error();
    } catch (const nb::python_error&) {
      raised = std::current_exception();
    }
  }
  PyEval_SaveThread();
  return goes_on;
}

}  // namespace

void run_with_progress(const nb::object& callback,
                       const std::function<void(const Progress&)>& work) {
  std::exception_ptr raised;
  try {
    leave_python([&](PyThreadState* thread) {
      work([&](double done) {
        if (must_end()) return false;
        enter(in_callback, own_in_callback);
        const bool goes_on = ask_python(thread, callback.ptr(), done, raised);
        leave(in_callback, own_in_callback);
        return goes_on && !must_end();
      });
    });
  } catch (const Cancelled&) {
    if (!raised && must_end()) {
      // The one exception that ends a thread without a word.
      PyErr_SetNone(PyExc_SystemExit);
      nb::raise_python_error();
    }
    if (!raised) throw;
  }
  if (raised) std::rethrow_exception(raised);
}

void run_long_work(const std::function<void()>& work) {
  run_with_progress(nb::none(), [&](const Progress& progress) {
    run_watched(progress, [&](WorkState&) { work(); });
  });
}

void end_work_at_exit() {
  system::at_fork_in_child(forget_other_threads);
  nb::module_::import_("atexit").attr("register")(nb::cpp_function([] {
    ends_python = true;
    ending = true;
    PyThreadState* const thread = PyEval_SaveThread();
    // A callback may wait for something that comes no more; it has a second.
    const auto patience = std::chrono::steady_clock::now() + std::chrono::seconds(1);
    const auto others_work = [&] {
      const int called_back = in_callback - own_in_callback;
      if (called_back > 0 && std::chrono::steady_clock::now() < patience) return true;
      return in_engine - own_in_engine > called_back;
    };
    while (others_work()) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    PyEval_RestoreThread(thread);
  }));
}

}  // namespace omma::python
