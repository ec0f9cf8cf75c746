/* Linked into wheels (scripts/wheel), where the linker sends all calls of hypot here: the version of
 * hypot that every glibc on x86-64 has, instead of the one that only 2.35 and newer have. On
 * such a glibc they differ in nothing but errno, which Omma does not read. */
double hypot_of_every_glibc(double x, double y);
__asm__(".symver hypot_of_every_glibc,hypot@GLIBC_2.2.5");

__attribute__((visibility("hidden"))) double __wrap_hypot(double x, double y);
double __wrap_hypot(double x, double y) { return hypot_of_every_glibc(x, y); }
