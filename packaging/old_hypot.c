/* Linked into wheels (scripts/wheel), where the linker sends all calls of hypot and hypotf here: the
 * versions that every glibc on x86-64 has, instead of those that only 2.35 and newer have. On such a
 * glibc they differ in nothing but errno, which Omma does not read. */
double hypot_of_every_glibc(double x, double y);
__asm__(".symver hypot_of_every_glibc,hypot@GLIBC_2.2.5");

float hypotf_of_every_glibc(float x, float y);
__asm__(".symver hypotf_of_every_glibc,hypotf@GLIBC_2.2.5");

__attribute__((visibility("hidden"))) double __wrap_hypot(double x, double y);
double __wrap_hypot(double x, double y) { return hypot_of_every_glibc(x, y); }

__attribute__((visibility("hidden"))) float __wrap_hypotf(float x, float y);
float __wrap_hypotf(float x, float y) { return hypotf_of_every_glibc(x, y); }
