// An eye in a notebook: azimuth and elevation of its axes, coloured by acceptance angle.
#include "eye_html.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <string_view>

#include "model/text.h"

namespace omma::python {
namespace {

// Of more ommatidia as many are drawn, evenly among all.
constexpr std::size_t most_dots = 12000;
constexpr double px_per_degree = 1.15;
// The upper left corner of the map, px.
constexpr double left = 52, top = 10;
constexpr double width = 360 * px_per_degree, height = 180 * px_per_degree;
constexpr double bar_left = left + width + 16, bar_width = 12;
// From dark to light, even steps to the eye: samples of Matplotlib's viridis.
constexpr std::array<const char*, 10> colours = {"#440154", "#482878", "#3e4989", "#31688e",
                                                 "#26828e", "#1f9e89", "#35b779", "#6ece58",
                                                 "#b5de2b", "#fde725"};

template <typename... Values>
std::string format(const char* pattern, Values... values) {
  std::array<char, 512> text{};
  std::snprintf(text.data(), text.size(), pattern, values...);
  return text.data();
}

std::string escaped(std::string_view text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else
      result += c;
  }
  return result;
}

// 12,345
std::string grouped(std::size_t number) {
  std::string digits = std::to_string(number);
  for (std::size_t end = digits.size(); end > 3;) digits.insert(end -= 3, ",");
  return digits;
}

double x_of(double azimuth_deg) {
  return left + (azimuth_deg + 180) * px_per_degree;
}

double y_of(double elevation_deg) {
  return top + (90 - elevation_deg) * px_per_degree;
}

std::string text_at(double x, double y, const char* more, const std::string& text) {
  return format("<text x=\"%.1f\" y=\"%.1f\" %s>", x, y, more) + text + "</text>";
}

// Beside the middle of the map, from the bottom up.
std::string upright(double x, const std::string& text) {
  return format("<g transform=\"translate(%.1f %.1f) rotate(-90)\">", x, y_of(0)) +
         text_at(0, 0, "text-anchor=\"middle\"", text) + "</g>";
}

std::string grid() {
  std::string lines, labels;
  for (int azimuth = -180; azimuth <= 180; azimuth += 90) {
    lines += format("M%.1f %.1fv%.1f", x_of(azimuth), top, height);
    labels += text_at(x_of(azimuth), top + height + 14, "text-anchor=\"middle\"",
                      format("%s%d°", azimuth < 0 ? "−" : "", std::abs(azimuth)));
  }
  for (int elevation = -90; elevation <= 90; elevation += 45) {
    lines += format("M%.1f %.1fh%.1f", left, y_of(elevation), width);
    labels += text_at(left - 5, y_of(elevation) + 4, "text-anchor=\"end\"",
                      format("%s%d°", elevation < 0 ? "−" : "", std::abs(elevation)));
  }
  labels += text_at(x_of(0), top + height + 30, "text-anchor=\"middle\"",
                    "azimuth, to the right of ahead");
  labels += upright(12, "elevation");
  return "<path d=\"" + lines +
         "\" fill=\"none\" stroke=\"currentColor\" stroke-opacity=\"0.25\"/>" + labels;
}

struct Range {
  double low_deg, high_deg;

  std::size_t colour_of(double angle_deg) const {
    if (!(high_deg > low_deg)) return colours.size() / 2;
    const double share = (angle_deg - low_deg) / (high_deg - low_deg);
    return std::min(static_cast<std::size_t>(share * colours.size()), colours.size() - 1);
  }
};

std::string colour_bar(const Range& range) {
  const bool one = range.colour_of(range.low_deg) == range.colour_of(range.high_deg);
  const double step = height / colours.size();
  std::string bar;
  for (std::size_t k = 0; k < colours.size(); ++k)
    bar += format("<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.2f\" fill=\"%s\"/>",
                  bar_left, top + height - (k + 1.0) * step, bar_width, step + 0.3,
                  colours[one ? range.colour_of(range.low_deg) : k]);
  const double beside = bar_left + bar_width + 5;
  if (one) {
    bar += text_at(beside, top + height / 2 + 4, "", format("%.3g°", range.low_deg));
  } else {
    bar += text_at(beside, top + 8, "", format("%.3g°", range.high_deg));
    bar += text_at(beside, top + height, "", format("%.3g°", range.low_deg));
  }
  return bar + upright(bar_left + bar_width + 60, "acceptance angle");
}

std::string dots(const Eye& eye, const Range& range, std::size_t eyes) {
  const std::size_t count = std::min(eye.size(), most_dots);
  std::array<std::string, colours.size()> paths;
  for (std::size_t k = 0; k < count; ++k) {
    const std::size_t i = k * eye.size() / count;
    const Vec2 angles = azimuth_elevation_rad(eye.axis[i]);
    paths[range.colour_of(eye.acceptance_angle_rad[i] / degree)] +=
        format("M%.1f %.1fh0", x_of(angles.x / degree), y_of(angles.y / degree));
  }
  // As wide as ommatidia are apart where each eye sees half of all directions.
  const double apart_deg = std::sqrt(41253.0 / 2 * static_cast<double>(eyes) / count);
  const double diameter = std::clamp(0.85 * apart_deg * px_per_degree, 1.5, 9.0);
  std::string all;
  for (std::size_t k = 0; k < colours.size(); ++k)
    if (!paths[k].empty())
      all += format("<path stroke=\"%s\" d=\"", colours[k]) + paths[k] + "\"/>";
  return format("<g fill=\"none\" stroke-width=\"%.1f\" stroke-linecap=\"round\">", diameter) +
         all + "</g>";
}

std::string caption(const Eye& eye, const std::map<std::int32_t, std::size_t>& count_of) {
  std::string text = "<b>omma.Eye</b> ";
  if (!eye.path.empty()) text += escaped(readable_text(without_folder(eye.path, eye.path))) + ": ";
  text += grouped(eye.size()) + (eye.size() == 1 ? " ommatidium" : " ommatidia");
  if (count_of.size() > 4) {
    text += " of " + std::to_string(count_of.size()) + " eyes";
  } else if (count_of.size() > 1) {
    for (const auto& [id, count] : count_of)
      text += (id == count_of.begin()->first ? "; eye " : ", eye ") + std::to_string(id) + ": " +
              grouped(count);
  }
  if (eye.size() > most_dots) text += "; " + grouped(most_dots) + " of them drawn";
  return text;
}

}  // namespace

std::string eye_html(const Eye& eye) {
  std::map<std::int32_t, std::size_t> count_of;
  for (const std::int32_t id : eye.eye_id) ++count_of[id];
  const auto [low, high] =
      std::minmax_element(eye.acceptance_angle_rad.begin(), eye.acceptance_angle_rad.end());
  const Range range{*low / degree, *high / degree};
  const double right = bar_left + bar_width + 66, bottom = top + height + 36;
  return "<div>" + caption(eye, count_of) + "</div>" +
         format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%.0f\" height=\"%.0f\" "
             "viewBox=\"0 0 %.0f %.0f\" font-family=\"sans-serif\" font-size=\"11\" "
             "fill=\"currentColor\" role=\"img\" aria-label=\"axes of the ommatidia\">",
             right, bottom, right, bottom) +
         grid() + dots(eye, range, count_of.size()) + colour_bar(range) + "</svg>";
}

}  // namespace omma::python
