// Averages images over ever larger squares, in linear light.
#include "backend/texture_levels.h"

#include <algorithm>
#include <cmath>

#include "threads/parallel.h"

namespace omma {
namespace {

// sRGB code value in [0, 1] to linear (IEC 61966-2-1).
double linear_from_srgb(double s) {
  return s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
}

// What an 8-bit code of colour stands for. 16 bits hold linear light to within 7.6e-6 of full
// scale.
std::vector<std::int32_t> values_of_codes(ImageCodes codes) {
  std::vector<std::int32_t> values;
  for (int i = 0; i < 256; ++i) {
    const double code = i / 255.0;
    const double value = codes == ImageCodes::srgb ? linear_from_srgb(code) : code;
    values.push_back(static_cast<std::int32_t>(std::lround(65535.0 * value)));
  }
  return values;
}

// Reading a texel of this costs one load and one conversion instead of four table look-ups.
void linear16_from_srgb8(const std::vector<std::uint8_t>& rgba,
                         const std::vector<std::int32_t>& color, std::int32_t* linear) {
  parallel_for(std::size_t{0}, rgba.size() / 4, [&](std::size_t i) {
    const std::uint8_t* p = rgba.data() + 4 * i;
    linear[2 * i] = color[p[0]] | color[p[1]] << 16;
    linear[2 * i + 1] = color[p[2]] | 257 * p[3] << 16;
  });
}

struct Texel {
  float r, g, b, a;
};

// Levels other than the image itself, before they are rounded.
struct Level {
  int width = 0, height = 0;
  std::vector<Texel> texels;
};

int half(int size) {
  return (size + 1) / 2;
}

// Texels of the finer level that lie within texel i of the coarser, and how much of each. Sizes
// that are not even make texels of one and a half and more: every one of the finer level has the
// same weight altogether, which is what keeps the mean.
struct Taps {
  int first = 0, count = 0;
  double weight[3] = {};  // sum 1

  Taps(int i, int size) {
    const double ratio = static_cast<double>(size) / half(size);
    const double begin = i * ratio, end = begin + ratio;
    first = static_cast<int>(begin);
    for (; first + count < size && first + count < end && count < 3; ++count) {
      const double covered =
          std::min(end, first + count + 1.0) - std::max<double>(begin, first + count);
      weight[count] = covered / ratio;
    }
  }
};

// The mean of the texels that the taps name. `read(x, y)` gives a texel of the finer level, its
// alpha the weight that its colour is seen with.
template <typename Read>
Texel mean_of(const Taps& across, const Taps& down, const Read& read) {
  double seen[3] = {}, plain[3] = {}, alpha = 0;
  for (int j = 0; j < down.count; ++j)
    for (int i = 0; i < across.count; ++i) {
      const Texel t = read(across.first + i, down.first + j);
      const double w = down.weight[j] * across.weight[i];
      const float color[3] = {t.r, t.g, t.b};
      for (int c = 0; c < 3; ++c) seen[c] += w * t.a * color[c], plain[c] += w * color[c];
      alpha += w * t.a;
    }
  // Where nothing is seen the colours still count for the neighbours that interpolate.
  const auto value = [&](int c) {
    return static_cast<float>(alpha > 0 ? seen[c] / alpha : plain[c]);
  };
  return {value(0), value(1), value(2), static_cast<float>(alpha)};
}

// Box-filters a level to half its width and height, row by row, and at once the next level, which
// alone is kept in memory: level 1 of a large image would take as much as the image. `keep(row,
// texels)` takes the rows of the first.
template <typename Read, typename Keep>
Level make_two_levels(int width, int height, const Read& read, const Keep& keep) {
  const int first_width = half(width), first_height = half(height);
  const auto row_size = static_cast<std::size_t>(first_width);
  Level level{half(first_width), half(first_height), {}};
  const auto level_row = static_cast<std::size_t>(level.width);
  level.texels.resize(level_row * static_cast<std::size_t>(level.height));
  parallel_for(0, level.height, [&](int row) {
    const Taps down(row, first_height);
    std::vector<Texel> rows(row_size * static_cast<std::size_t>(down.count));
    for (int j = 0; j < down.count; ++j) {
      const Taps above(down.first + j, height);
      for (int column = 0; column < first_width; ++column)
        rows[static_cast<std::size_t>(j) * row_size + static_cast<std::size_t>(column)] =
            mean_of(Taps(column, width), above, read);
      // Rows that two rows of the next level share are the upper one's or the lower one's.
      if ((down.first + j) / 2 == row)
        keep(down.first + j, rows.data() + static_cast<std::size_t>(j) * row_size);
    }
    const auto read_row = [&](int x, int y) {
      return rows[static_cast<std::size_t>(y - down.first) * row_size +
                  static_cast<std::size_t>(x)];
    };
    for (int column = 0; column < level.width; ++column)
      level.texels[static_cast<std::size_t>(row) * level_row + static_cast<std::size_t>(column)] =
          mean_of(Taps(column, first_width), down, read_row);
  });
  return level;
}

// A colour component or alpha as 16 bits.
std::uint32_t round16(float value) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0f, 1.0f) * 65535.0f));
}

}  // namespace

TextureLevels make_texture_levels(const Image& image, ImageCodes codes, AlphaMode alpha,
                                  bool levels, bool large) {
  TextureLevels result;
  result.first_texel.push_back(0);
  const bool eight_bit = !image.rgba_srgb8.empty();
  const auto width = static_cast<std::size_t>(image.width);
  const std::size_t image_texels = width * static_cast<std::size_t>(image.height);
  std::size_t texels = image_texels;
  if (levels)
    for (int w = image.width, h = image.height; w > 1 || h > 1;) {
      if (texels > INT32_MAX / 4) break;
      result.first_texel.push_back(static_cast<std::int32_t>(texels));
      w = half(w), h = half(h);
      texels += static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    }
  const std::vector<std::int32_t> value_of_code = values_of_codes(codes);
  // Where the 16-bit values of a texel are.
  const std::size_t texels_elsewhere = large ? image_texels : 0;
  if (eight_bit) {
    result.linear16.resize(2 * (texels - texels_elsewhere));
    if (large)
      result.value_of_code = value_of_code;
    else
      linear16_from_srgb8(image.rgba_srgb8, value_of_code, result.linear16.data());
  } else if (result.first_texel.size() > 1) {
    result.linear.resize(4 * texels);
    std::copy(image.rgba_linear.begin(), image.rgba_linear.end(), result.linear.begin());
  }

  const auto read_image = [&](int x, int y) {
    const std::size_t i = static_cast<std::size_t>(y) * width + static_cast<std::size_t>(x);
    Texel t;
    if (eight_bit) {
      constexpr float unit = 1.0f / 65535.0f;
      const std::uint8_t* p = image.rgba_srgb8.data() + 4 * i;
      const auto color = [&](int c) { return static_cast<float>(value_of_code[p[c]]) * unit; };
      t = {color(0), color(1), color(2), static_cast<float>(257 * p[3]) * unit};
    } else {
      const float* p = image.rgba_linear.data() + 4 * i;
      t = {p[0], p[1], p[2], p[3]};
    }
    if (alpha != AlphaMode::blend) t.a = 1;
    return t;
  };
  const auto keep = [&](std::size_t i, const Texel& t) {
    if (eight_bit) {
      std::int32_t* p = result.linear16.data() + 2 * (i - texels_elsewhere);
      p[0] = static_cast<std::int32_t>(round16(t.r) | round16(t.g) << 16);
      p[1] = static_cast<std::int32_t>(round16(t.b) | round16(t.a) << 16);
    } else {
      float* p = result.linear.data() + 4 * i;
      p[0] = t.r, p[1] = t.g, p[2] = t.b, p[3] = t.a;
    }
  };
  Level finer;
  const auto read_level = [&](int x, int y) {
    return finer.texels[static_cast<std::size_t>(y) * static_cast<std::size_t>(finer.width) +
                        static_cast<std::size_t>(x)];
  };
  for (std::size_t l = 1; l < result.first_texel.size(); l += 2) {
    const auto first = static_cast<std::size_t>(result.first_texel[l]);
    const int finer_width = l == 1 ? image.width : finer.width;
    const auto keep_row = [&](int row, const Texel* row_texels) {
      const auto count = static_cast<std::size_t>(half(finer_width));
      for (std::size_t i = 0; i < count; ++i)
        keep(first + static_cast<std::size_t>(row) * count + i, row_texels[i]);
    };
    Level level = l == 1 ? make_two_levels(image.width, image.height, read_image, keep_row)
                         : make_two_levels(finer.width, finer.height, read_level, keep_row);
    if (l + 1 < result.first_texel.size()) {
      const auto second = static_cast<std::size_t>(result.first_texel[l + 1]);
      parallel_for(std::size_t{0}, level.texels.size(),
                   [&](std::size_t i) { keep(second + i, level.texels[i]); });
    }
    finer = std::move(level);
  }
  return result;
}

TextureView view_levels(const Image& image, const TextureLevels& levels) {
  TextureView view;
  view.width = image.width;
  view.height = image.height;
  view.last_level = static_cast<std::int32_t>(levels.first_texel.size()) - 1;
  view.first_texel = levels.first_texel.data();
  view.version = levels.version;
  if (!levels.value_of_code.empty()) {
    view.codes = image.rgba_srgb8.data();
    view.value_of_code = levels.value_of_code.data();
  }
  if (!image.rgba_srgb8.empty())
    view.linear16 = levels.linear16.data();
  else
    view.linear = levels.linear.empty() ? image.rgba_linear.data() : levels.linear.data();
  return view;
}

std::vector<float> texel_density(const Mesh& mesh, const Vec2* uvs, bool of_vertices,
                                 const TextureView& texture) {
  std::vector<float> density(mesh.triangles.size());
  parallel_for(std::size_t{0}, density.size(), [&](std::size_t i) {
    const auto corner = [&](std::size_t k) {
      return to_double(mesh.positions[mesh.triangles[i][k]]);
    };
    const Vec3d e = corner(1) - corner(0), f = corner(2) - corner(0);
    // In the plane of the triangle e = (along, 0) and f = (x, y).
    const double along = length(e), twice_area = length(cross(e, f));
    const double x = dot(e, f) / along, y = twice_area / along;
    const auto uv = [&](std::size_t k) {
      return uvs[of_vertices ? mesh.triangles[i][k] : 3 * i + k];
    };
    const auto texels = [&](std::size_t k, double& s, double& t) {
      s = (static_cast<double>(uv(k).x) - uv(0).x) * texture.width;
      t = (static_cast<double>(uv(k).y) - uv(0).y) * texture.height;
    };
    double s_e, t_e, s_f, t_f;
    texels(1, s_e, t_e);
    texels(2, s_f, t_f);
    // Gradients of the two texel coordinates, and the smaller singular value of the matrix of both.
    const double s_x = s_e / along, s_y = (s_f - s_x * x) / y;
    const double t_x = t_e / along, t_y = (t_f - t_x * x) / y;
    const double s2 = s_x * s_x + s_y * s_y, t2 = t_x * t_x + t_y * t_y;
    const double det = s_x * t_y - s_y * t_x, both = s2 + t2;
    double least2 = 2 * det * det / (both + std::sqrt(std::max(0.0, both * both - 4 * det * det)));
    // Along an extent of one texel there is nothing to average.
    if (texture.width == 1) least2 = t2;
    if (texture.height == 1) least2 = s2;
    const double least = std::sqrt(least2);
    density[i] = std::isfinite(least) && least < 1e30 ? static_cast<float>(least) : 0.0f;
  });
  return density;
}

float panorama_density(const TextureView& image) {
  const double across = image.width / (2 * pi), down = image.height / pi;
  if (image.width == 1) return static_cast<float>(down);
  if (image.height == 1) return static_cast<float>(across);
  return static_cast<float>(std::min(across, down));
}

}  // namespace omma
