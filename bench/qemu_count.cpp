// A plugin of QEMU (7.2 and newer, its user mode) that counts the instructions a program executes on
// the emulated processor, and those of each function; scripts/lanes calls it. Declared here is what
// it uses of QEMU's qemu-plugin.h, which Debian's packages do not have: version 1 of that interface.
//
//   qemu-aarch64 -plugin libqemu_count.so,functions=20 program
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

extern "C" {
using qemu_plugin_id_t = std::uint64_t;
struct qemu_plugin_tb;
struct qemu_plugin_insn;
void qemu_plugin_register_vcpu_tb_trans_cb(qemu_plugin_id_t,
                                           void (*)(qemu_plugin_id_t, qemu_plugin_tb*));
void qemu_plugin_register_vcpu_tb_exec_inline(qemu_plugin_tb*, int operation, void* counter,
                                              std::uint64_t added);
void qemu_plugin_register_atexit_cb(qemu_plugin_id_t, void (*)(qemu_plugin_id_t, void*), void*);
std::size_t qemu_plugin_tb_n_insns(const qemu_plugin_tb*);
qemu_plugin_insn* qemu_plugin_tb_get_insn(const qemu_plugin_tb*, std::size_t);
const char* qemu_plugin_insn_symbol(const qemu_plugin_insn*);
}

extern "C" {
int qemu_plugin_version = 1;
}

namespace {

std::size_t functions = 0;  // so many are listed
std::map<std::string, std::unique_ptr<std::uint64_t>> counts;  // by function

std::mutex counting;

// Threads translate side by side. Counters are not locked: of what several threads execute at once
// some may be lost, but the renders that are counted have one.
void translated(qemu_plugin_id_t, qemu_plugin_tb* block) {
  const std::lock_guard lock(counting);
  const char* name = qemu_plugin_insn_symbol(qemu_plugin_tb_get_insn(block, 0));
  std::unique_ptr<std::uint64_t>& count = counts[name != nullptr ? name : "(no name)"];
  if (count == nullptr) count = std::make_unique<std::uint64_t>(0);
  constexpr int add_64 = 0;  // QEMU_PLUGIN_INLINE_ADD_U64
  qemu_plugin_register_vcpu_tb_exec_inline(block, add_64, count.get(),
                                           qemu_plugin_tb_n_insns(block));
}

void finished(qemu_plugin_id_t, void*) {
  std::vector<std::pair<std::uint64_t, std::string>> most;
  std::uint64_t all = 0;
  for (const auto& [name, count] : counts) {
    all += *count;
    most.emplace_back(*count, name);
  }
  std::fprintf(stderr, "%llu instructions\n", static_cast<unsigned long long>(all));
  std::sort(most.rbegin(), most.rend());
  most.resize(std::min(most.size(), functions));
  for (const auto& [count, name] : most)
    std::fprintf(stderr, "%llu %s\n", static_cast<unsigned long long>(count), name.c_str());
}

}  // namespace

extern "C" int qemu_plugin_install(qemu_plugin_id_t id, const void*, int argc, char** argv) {
  for (int i = 0; i < argc; ++i)
    if (std::strncmp(argv[i], "functions=", 10) == 0) functions = std::stoul(argv[i] + 10);
  qemu_plugin_register_vcpu_tb_trans_cb(id, translated);
  qemu_plugin_register_atexit_cb(id, finished, nullptr);
  return 0;
}
