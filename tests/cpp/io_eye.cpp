// `.eye` files: what may be written in one, what may not and where the error points, and that an
// eye survives being saved.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>

#include "omma/error.h"
#include "omma/io.h"

namespace {

using omma::Error;
using omma::Eye;
using omma::parse_eye;
using omma::Vec3;

const std::string good_line = "1 2 3 0 0 1 0.045 0.25";

std::string error_of(const std::string& text, double metres_per_unit = 1e-3) {
  try {
    parse_eye(text, "bee.eye", metres_per_unit);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

void expect_error(const std::string& text, const std::string& place, const std::string& what) {
  const std::string message = error_of(text);
  EXPECT_NE(message.find("bee.eye, " + place), std::string::npos) << text << "\n" << message;
  EXPECT_NE(message.find(what), std::string::npos) << text << "\n" << message;
}

void expect_same(const Eye& a, const Eye& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a.position_m[i].x, b.position_m[i].x);
    EXPECT_EQ(a.position_m[i].y, b.position_m[i].y);
    EXPECT_EQ(a.position_m[i].z, b.position_m[i].z);
    EXPECT_EQ(a.axis[i].x, b.axis[i].x);
    EXPECT_EQ(a.axis[i].y, b.axis[i].y);
    EXPECT_EQ(a.axis[i].z, b.axis[i].z);
    EXPECT_EQ(a.acceptance_angle_rad[i], b.acceptance_angle_rad[i]);
    EXPECT_EQ(a.focal_offset_m[i], b.focal_offset_m[i]);
  }
}

class Folder {
 public:
  Folder() {
    path_ = std::filesystem::path(testing::TempDir()) /
            ("omma_io_eye_" + std::to_string(std::random_device{}()));
    std::filesystem::create_directories(path_);
  }
  ~Folder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  std::string file(const std::string& name) const { return (path_ / name).string(); }
  std::size_t file_count() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path_)) ++count;
    return count;
  }

 private:
  std::filesystem::path path_;
};

TEST(EyeFile, TurnsTheFrameAndTheUnit) {
  const Eye eye = parse_eye("1 2 3 0.6 0 0.8 0.045 0.25", "bee.eye");
  ASSERT_EQ(eye.size(), 1u);
  EXPECT_EQ(eye.path, "bee.eye");
  EXPECT_FLOAT_EQ(eye.position_m[0].x, 1e-3f);
  EXPECT_FLOAT_EQ(eye.position_m[0].y, 2e-3f);
  EXPECT_FLOAT_EQ(eye.position_m[0].z, -3e-3f);
  EXPECT_FLOAT_EQ(eye.axis[0].x, 0.6f);
  EXPECT_FLOAT_EQ(eye.axis[0].y, 0.0f);
  EXPECT_FLOAT_EQ(eye.axis[0].z, -0.8f);
  EXPECT_FLOAT_EQ(eye.acceptance_angle_rad[0], 0.045f);
  EXPECT_FLOAT_EQ(eye.focal_offset_m[0], 0.25e-3f);
  EXPECT_EQ(eye.eye_id[0], 0);
  const Eye scene_units = parse_eye("1 2 3 0.6 0 0.8 0.045 0.25", "", 1.0);
  EXPECT_FLOAT_EQ(scene_units.position_m[0].z, -3.0f);
  EXPECT_FLOAT_EQ(scene_units.focal_offset_m[0], 0.25f);
}

TEST(EyeFile, NormalisesAxesOfAnyLength) {
  for (const char* axis : {"0 3 4", "0 3e-300 4e-300", "0 3e300 4e300"}) {
    const Eye eye = parse_eye(std::string("0 0 0 ") + axis + " 0.1 0", "bee.eye");
    EXPECT_FLOAT_EQ(eye.axis[0].x, 0.0f) << axis;
    EXPECT_FLOAT_EQ(eye.axis[0].y, 0.6f) << axis;
    EXPECT_FLOAT_EQ(eye.axis[0].z, -0.8f) << axis;
  }
}

TEST(EyeFile, SeparatorsLineEndsAndCommentsMeanTheSame) {
  const Eye plain = parse_eye(good_line + "\n" + good_line + "\n", "bee.eye");
  ASSERT_EQ(plain.size(), 2u);
  for (const std::string& line :
       {std::string("1,2,3,0,0,1,0.045,0.25"), std::string("1, 2, 3, 0, 0, 1, 0.045, 0.25"),
        std::string("1 ,2 ,3\t,\t0 0 1,0.045  0.25"), std::string("1\t2\t3\t0\t0\t1\t0.045\t0.25"),
        std::string("  1 2 3 0 0 1 0.045 0.25  "), std::string("+1 2.0 3e0 0 0 1 .045 25e-2"),
        std::string("1 2 3 0 0 1 0.045 0.25# said of one"),
        std::string("1 2 3 0 0 1 0.045 0.25 # a comment, with commas")}) {
    for (const std::string& end : {std::string("\n"), std::string("\r\n")}) {
      SCOPED_TRACE(line);
      expect_same(parse_eye(line + end + line + end, "bee.eye"), plain);
      expect_same(parse_eye(line + end + line, "bee.eye"), plain);
      expect_same(
          parse_eye("# head" + end + end + line + end + "  \t" + end + line + end + end, "bee.eye"),
          plain);
    }
  }
  expect_same(parse_eye("\xef\xbb\xbf" + good_line + "\n" + good_line, "bee.eye"), plain);
}

TEST(EyeFile, ErrorsNameFileLineAndColumn) {
  expect_error("1 2 3 0 0 1 0.045", "line 1, column 8 (focal offset)", "missing");
  expect_error("1 2 3 0 0 1 0.045 # 0.25", "line 1, column 8", "missing");
  expect_error(good_line + "\n1\n", "line 2, column 2 (position y)", "missing");
  expect_error(good_line + " 7", "line 1, column 9", "found more: \"7\"");
  expect_error("1,,3,0,0,1,0.045,0.25", "line 1, column 2", "empty");
  expect_error("1, ,3,0,0,1,0.045,0.25", "line 1, column 2", "empty");
  expect_error(",1,2,3,0,0,1,0.045", "line 1, column 1", "empty");
  expect_error("1,2,3,0,0,1,0.045,", "line 1, column 8", "empty");
  expect_error(good_line + ",", "line 1, column 9", "comma");
  expect_error("1,2,3,0,0,1,0.045,0.25,,", "line 1, column 9", "more");
  expect_error("# c\r\n\r\n1 2 three 0 0 1 0.045 0.25", "line 3, column 3 (position z)",
               "\"three\"");
  expect_error("1 2 3.4.5 0 0 1 0.045 0.25", "line 1, column 3", "\"3.4.5\"");
  expect_error("1 2 0x3 0 0 1 0.045 0.25", "line 1, column 3", "\"0x3\"");
  expect_error("1 2 +-3 0 0 1 0.045 0.25", "line 1, column 3", "\"+-3\"");
  expect_error("1 2 + 0 0 1 0.045 0.25", "line 1, column 3", "\"+\"");
  expect_error("1 2 3 0 nan 1 0.045 0.25", "line 1, column 5 (axis y)", "finite");
  expect_error("1 inf 3 0 0 1 0.045 0.25", "line 1, column 2", "finite");
  expect_error("1 2 3 0 0 1 0.045 1e999", "line 1, column 8", "out of range");
  expect_error("1 1e300 3 0 0 1 0.045 0", "line 1, column 2", "out of range");
  expect_error("1 2 3 0 0 0 0.045 0.25", "line 1, column 4", "axis (columns 4 to 6)");
  expect_error("1 2 3 0 0 1 -0.001 0.25", "line 1, column 7 (acceptance angle)", "2 pi");
  expect_error("1 2 3 0 0 1 6.2832 0.25", "line 1, column 7", "2 pi");
  expect_error("1 2 3 0 0 1 1e300 0.25", "line 1, column 7", "2 pi");
  expect_error("1 2 3 0 0 1 0.045 -0.25", "line 1, column 8", "at least 0");
  expect_error(std::string("1 2 3\0 0 0 1 0.045 0.25", 23), "line 1, column 3", "\"3?\"");
  expect_error("\x1b[31m 2 3 0 0 1 0.045 0.25", "line 1, column 1", "\"?[31m\"");
  // A long word is cut, so that a binary file does not become the message.
  EXPECT_LT(error_of(std::string(100000, 'x')).size(), 200u);
}

TEST(EyeFile, WithoutAnyOmmatidiumIsAnError) {
  for (const char* text : {"", "\n", "# only a comment\n\n", "\xef\xbb\xbf", "   \r\n"})
    EXPECT_EQ(error_of(text), "bee.eye: expected at least one ommatidium, found none");
}

TEST(EyeFile, TheUnitMustBePositive) {
  for (const double unit : {0.0, -1.0, std::nan(""), HUGE_VAL})
    EXPECT_NE(error_of(good_line, unit).find("metres_per_unit"), std::string::npos) << unit;
}

TEST(EyeFile, AFullTurnIsTheWidestAcceptance) {
  const Eye eye = parse_eye("0 0 0 0 0 1 6.283185307179586 0", "bee.eye");
  EXPECT_EQ(eye.acceptance_angle_rad[0], static_cast<float>(2 * omma::pi));
}

Eye random_eye(std::size_t count, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> share(0.0f, 1.0f);
  Eye eye;
  for (std::size_t i = 0; i < count; ++i) {
    eye.position_m.push_back(
        {normal(random) * 1e-3f, normal(random) * 1e-6f, normal(random) * 10.0f});
    eye.axis.push_back({normal(random), normal(random), normal(random)});
    eye.acceptance_angle_rad.push_back(share(random) * 6.28f);
    eye.focal_offset_m.push_back(share(random) * 1e-3f);
    eye.eye_id.push_back(0);
  }
  eye.acceptance_angle_rad[0] = static_cast<float>(2 * omma::pi);
  eye.position_m[0] = {0.0f, -0.0f, 1e-42f};
  omma::validate_eye(eye);
  return eye;
}

TEST(EyeFile, SavedAndLoadedIsTheSameToTheLastBit) {
  const Folder folder;
  const Eye eye = random_eye(2000, 1);
  for (const double unit : {1e-3, 1.0, 0.0254}) {
    const std::string path = folder.file("saved.eye");
    omma::save_eye(path, eye, unit);
    const Eye loaded = omma::load_eye(path, unit);
    EXPECT_EQ(loaded.path, path);
    expect_same(loaded, eye);
  }
  EXPECT_EQ(folder.file_count(), 1u);  // no temporary file is left
}

TEST(EyeFile, SavedFilesAreNumbersAndSpacesOnly) {
  // CompoundRay counts a file's lines and reads every one as eight numbers.
  const Folder folder;
  const std::string path = folder.file("plain.eye");
  omma::save_eye(path, random_eye(3, 2));
  std::ifstream file(path, std::ios::binary);
  const std::string text(std::istreambuf_iterator<char>(file), {});
  EXPECT_EQ(text.find_first_not_of("0123456789.e+- \n"), std::string::npos) << text;
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  EXPECT_EQ(std::count(text.begin(), text.end(), ' '), 3 * 7);
}

TEST(EyeFile, FilesThatCannotBeReadOrWrittenAreNamed) {
  const Folder folder;
  const Eye eye = random_eye(2, 3);
  const auto message_of = [](const auto& action) -> std::string {
    try {
      action();
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  const std::string missing = folder.file("none/bee.eye");
  EXPECT_NE(message_of([&] { omma::load_eye(missing); }).find(missing), std::string::npos);
  EXPECT_NE(message_of([&] { omma::save_eye(missing, eye); }).find(missing), std::string::npos);
  EXPECT_NE(message_of([&] { omma::load_eye(folder.file("")); }).find(folder.file("")),
            std::string::npos);
  Eye broken = eye;
  broken.axis[1] = {0, 0, 0};
  EXPECT_NE(message_of([&] { omma::save_eye(folder.file("x.eye"), broken); }).find("ommatidium 1"),
            std::string::npos);
  for (const char* name : {"bee.foo", "bee", "bee.eye.txt"})
    EXPECT_NE(message_of([&] { omma::save_eye(folder.file(name), eye); }).find("ending in .csv"),
              std::string::npos);
  EXPECT_EQ(folder.file_count(), 0u);
}

TEST(EyeFile, RealEyesHaveTheKnownNumbersOfOmmatidia) {
  const std::filesystem::path data = std::filesystem::path(OMMA_SHARED_DATA) / "compound-ray";
  if (!std::filesystem::exists(data)) GTEST_SKIP() << "no data at " << data;
  const std::pair<const char*, std::size_t> known[] = {
      {"bees/AM_60185-real.eye", 6374},
      {"bees/AM_60185-single.eye", 6374},
      {"bees/AM_60185-split.eye", 6374},
      {"bees/BT_77967-real.eye", 9654},
      {"bees/BT_77973-real.eye", 3778},
      {"scenes/1000-horizontallyAcute-variableDegree.eye", 1000},
      {"scenes/test.eye", 1000},
      {"scenes/test100.eye", 100},
      {"scenes/eyes/1000-equidistant.eye", 1000},
      {"scenes/eyes/1000-horizontallyAcute-variableDegree.eye", 1000},
      {"scenes/eyes/AM_60185-real.eye", 6374},
      {"scenes/eyes/test100-avgRadius-0.1.eye", 100},
      {"scenes/eyes/test1000-avgRadius-0.1.eye", 1000},
      {"scenes/eyes/test1000-horizontallyAcute-2.6degrees-avgRadius-0.1.eye", 1000},
      {"scenes/eyes/test1000-horizontallyAcute-2.6degrees-avgRadius-0.2.eye", 1000},
      {"scenes/eyes/test1000-horizontallyAcute-variableDegree-avgRadius-0.2.eye", 1000}};
  for (const auto& [name, count] : known) {
    Eye eye = omma::load_eye((data / name).string());
    EXPECT_EQ(eye.size(), count) << name;
    EXPECT_NO_THROW(omma::validate_eye(eye)) << name;
  }
}

}  // namespace
