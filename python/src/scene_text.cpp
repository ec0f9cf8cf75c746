// A scene as text: see scene_text.h.
#include "scene_text.h"

#include <cmath>
#include <cstdio>

#include "model/text.h"

namespace omma::python {

namespace {

// More cameras than these make a table nobody reads.
constexpr std::size_t most_rows = 20;

std::string escaped(const std::string& text) {
  std::string html;
  for (const char c : readable_text(text)) {
    if (c == '&')
      html += "&amp;";
    else if (c == '<')
      html += "&lt;";
    else if (c == '>')
      html += "&gt;";
    else
      html += c;
  }
  return html;
}

std::string row(const char* what, const std::string& value) {
  return std::string("<tr><th>") + what + "</th><td>" + value + "</td></tr>";
}

// 1234567 as 1,234,567.
std::string grouped(std::uint64_t number) {
  std::string text = std::to_string(number);
  for (std::size_t end = text.size(); end > 3; end -= 3) text.insert(end - 3, ",");
  return text;
}

// To four digits, and at least to the hundredth, as places far from the origin differ by less.
std::string number(double x) {
  char text[32];
  const bool far = std::abs(x) >= 100;
  std::snprintf(text, sizeof text, far ? "%.12g" : "%.4g", far ? std::round(100 * x) / 100 : x);
  return text;
}

std::string point(double x, double y, double z) {
  return number(x) + ", " + number(y) + ", " + number(z);
}

std::string background_text(const Background& background) {
  switch (background.type) {
    case BackgroundType::constant:
      return point(background.color.x, background.color.y, background.color.z);
    case BackgroundType::simple_sky:
      return "simple_sky";
    case BackgroundType::test_pattern:
      return "test_pattern";
    case BackgroundType::image:
      return "image, " + std::to_string(background.image.width) + " × " +
             std::to_string(background.image.height);
  }
  return "";
}

const char* camera_word(CameraType type) {
  switch (type) {
    case CameraType::perspective:
      return "perspective";
    case CameraType::orthographic:
      return "orthographic";
    case CameraType::panoramic:
      return "panoramic";
    case CameraType::compound:
      return "compound";
  }
  return "";
}

}  // namespace

std::string scene_repr(const Scene& scene) {
  return "<omma.Scene " +
         (scene.path.empty() ? "in memory"
                             : "'" + readable_text(without_folder(scene.path, scene.path)) + "'") +
         ": " + std::to_string(triangle_count(scene)) + " triangles, " +
         (scene.splats.empty() ? "" : std::to_string(splat_count(scene)) + " splats, ") +
         std::to_string(scene.cameras.size()) + " cameras>";
}

std::string scene_html(const Scene& scene) {
  std::string html = "<table><caption>omma.Scene " +
                     (scene.path.empty() ? "in memory"
                                         : escaped(without_folder(scene.path, scene.path))) +
                     "</caption>";
  html +=
      row("triangles", grouped(triangle_count(scene)) + " in " + grouped(scene.instances.size()) +
                           " instances of " + grouped(scene.meshes.size()) + " meshes");
  html += row("materials", grouped(scene.materials.size()) + ", with " +
                               grouped(scene.images.size()) + " images");
  const Bounds box = scene_bounds(scene);
  html += row("bounds", box.empty ? "empty"
                                  : point(box.lower.x, box.lower.y, box.lower.z) + " to " +
                                        point(box.upper.x, box.upper.y, box.upper.z) + " m");
  html += row("background", background_text(scene.background));
  if (!scene.splats.empty())
    html += row("splats", grouped(splat_count(scene)) + " Gaussian splats in " +
                              grouped(scene.splats.size()) + " clouds");
  if (!scene.lights.empty()) html += row("lights", grouped(scene.lights.size()));
  if (!scene.hit_boxes.empty()) html += row("hit boxes", grouped(scene.hit_boxes.size()));
  for (std::size_t i = 0; i < scene.cameras.size() && i < most_rows; ++i) {
    const Camera& camera = scene.cameras[i];
    const auto& m = camera.world_from_camera.m;
    html += row(("camera " + std::to_string(i)).c_str(),
                escaped(camera.name) + ", " + camera_word(camera.type) + ", at " +
                    point(m[0][3], m[1][3], m[2][3]) + " m");
  }
  if (scene.cameras.size() > most_rows)
    html += row("cameras", std::to_string(scene.cameras.size() - most_rows) + " more");
  for (const std::string& warning : scene.warnings) 
    html += row("warning", escaped(without_folder(warning, scene.path)));
  return html + "</table>";
}

}  // namespace omma::python
