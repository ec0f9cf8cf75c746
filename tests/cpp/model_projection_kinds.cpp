// Each projection on an eye of six known ommatidia: which pixel shows which; and areas where areas
// are promised.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "omma/error.h"
#include "projection_map.h"

namespace {

using namespace omma::test;
using omma::degree;
using omma::Error;
using omma::Eye;
using omma::Projection;
using omma::projection_ids;
using omma::Vec3;

TEST(Projection, SingleDimensionStretchesTheOmmatidia) {
  EXPECT_EQ(Map(eye_of(six, six), Projection::single_dimension, 12, 2).ids,
            (Ids{0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5}));
  EXPECT_EQ(Map(eye_of(six, six), Projection::single_dimension, 4, 1).ids, (Ids{0, 1, 3, 4}));
}

TEST(Projection, SingleDimensionFastIsOneRow) {
  const Eye eye = eye_of(six, six);
  EXPECT_EQ(Map(eye, Projection::single_dimension_fast, 7, 2).ids,
            (Ids{0, 1, 2, 3, 4, 5, -1, -1, -1, -1, -1, -1, -1, -1}));
  EXPECT_THROW(projection_ids(eye, Projection::single_dimension_fast, 5, 1), Error);
}

TEST(Projection, RawSamplesHaveAColumnPerOmmatidium) {
  const Eye eye = eye_of(six, six);
  EXPECT_EQ(Map(eye, Projection::raw_ommatidial_samples, 7, 2).ids,
            (Ids{0, 1, 2, 3, 4, 5, -1, 0, 1, 2, 3, 4, 5, -1}));
  EXPECT_THROW(projection_ids(eye, Projection::raw_ommatidial_samples, 5, 1), Error);
}

TEST(Projection, SphericalByAxisAndByPosition) {
  // By position the other way round: what looks ahead sits at the back.
  std::vector<Vec3> opposite;
  for (const Vec3 axis : six) opposite.push_back(axis * -0.001f);
  const Eye eye = eye_of(opposite, six);
  const Map by_axis(eye, Projection::spherical_orientationwise, 360, 180);
  const Map by_position(eye, Projection::spherical_positionwise, 360, 180);
  const struct {
    double azimuth_deg, elevation_deg;
    std::int32_t axis, position;
  } expected[] = {{1, 0, ahead, back},   {90, 0, right, left},   {-90, 0, left, right},
                  {179, 0, back, ahead}, {-179, 0, back, ahead}, {0, 89, up, down},
                  {170, -89, down, up},  {44, 1, ahead, back},   {46, 1, right, left}};
  for (const auto& [azimuth, elevation, axis, position] : expected) {
    EXPECT_EQ(by_axis.at(azimuth / 360 + 0.5, 0.5 - elevation / 180), axis) << azimuth;
    EXPECT_EQ(by_position.at(azimuth / 360 + 0.5, 0.5 - elevation / 180), position) << azimuth;
  }
}

TEST(Projection, SplitShowsEachSideItsOwn) {
  // Two ommatidia on the left, two on the right that look elsewhere, one in the middle.
  const Eye eye = eye_of({{-1, 0, 0}, {-1, 0.1f, 0}, {1, 0, 0}, {1, 0.1f, 0}, {0, 0, 0}},
                         {{0, 0, -1}, {1, 0, 0}, {0, 0, 1}, {-1, 0, 0}, {0, 1, 0}});
  const Map map(eye, Projection::spherical_split_orientationwise, 720, 180);
  EXPECT_EQ(map.at(0.25, 0.5), 0);   // left picture, straight ahead
  EXPECT_EQ(map.at(0.375, 0.5), 1);  // left picture, azimuth 90
  EXPECT_EQ(map.at(0.499, 0.6), 1);  // left picture, behind: the nearest is 90 degrees off
  EXPECT_EQ(map.at(0.501, 0.6), 2);  // right picture, behind
  EXPECT_EQ(map.at(0.625, 0.5), 3);  // right picture, azimuth -90
  EXPECT_EQ(map.at(0.1, 0.01), 4);   // up, in both
  EXPECT_EQ(map.at(0.9, 0.01), 4);
  // A side without ommatidia shows nothing.
  const Map one_sided(eye_of({{-1, 0, 0}}, {{0, 0, -1}}),
                      Projection::spherical_split_orientationwise, 20, 10);
  for (int row = 0; row < 10; ++row)
    for (int column = 0; column < 20; ++column)
      EXPECT_EQ(one_sided.pixel(column, row), column < 10 ? 0 : none);
}

TEST(Projection, CylindricalIsAzimuthAgainstHeight) {
  const Map map(eye_of(six, six), Projection::cylindrical, 361, 181);
  EXPECT_EQ(map.at(0.5, 0.5), ahead);
  EXPECT_EQ(map.at(0.75, 0.5), right);
  EXPECT_EQ(map.at(0.25, 0.5), left);
  EXPECT_EQ(map.at(0.0, 0.5), back);
  EXPECT_EQ(map.at(1.0, 0.5), back);
  EXPECT_EQ(map.at(0.62, 0.45), ahead);
  EXPECT_EQ(map.at(0.63, 0.55), right);
  // Up and down have no azimuth and count as ahead, at the edges.
  EXPECT_EQ(map.at(0.5, 0.2), up);
  EXPECT_EQ(map.at(0.5, 0.8), down);
  EXPECT_EQ(map.at(0.5, 0.3), ahead);
  EXPECT_EQ(map.at(0.0, 0.0), back);

  // The height is that of the position: here the lowest one looks up and the highest down.
  std::vector<Vec3> positions, axes;
  for (int i = 0; i <= 20; ++i) {
    const float height = 0.1f * static_cast<float>(i);
    positions.push_back({5, height - 7, 3});
    axes.push_back({1, 1 - height, 0});
  }
  const Map by_height(eye_of(positions, axes), Projection::cylindrical, 101, 210);
  for (int i = 0; i <= 20; ++i) EXPECT_EQ(by_height.at(0.75, 1 - i / 20.0), i) << i;
  EXPECT_EQ(by_height.at(0.25, 0.5), none);  // nothing looks left
  EXPECT_THROW(projection_ids(eye_of({{1, 2, 3}, {2, 2, 3}}, {{0, 0, -1}, {1, 0, 0}}),
                              Projection::cylindrical, 9, 9),
               Error);
}

TEST(Projection, MollweideIsTheWholeSphereInAnEllipse) {
  // Twice as high as needed: the ellipse takes the middle half.
  const Map map(eye_of(six, six), Projection::mollweide, 722, 722);
  EXPECT_EQ(map.at(0.5, 0.5), ahead);
  EXPECT_EQ(map.at(0.75, 0.5), right);
  EXPECT_EQ(map.at(0.25, 0.5), left);
  EXPECT_EQ(map.at(0.001, 0.5), back);
  EXPECT_EQ(map.at(0.999, 0.5), back);
  EXPECT_EQ(map.at(0.5, 0.255), up);
  EXPECT_EQ(map.at(0.5, 0.745), down);
  EXPECT_EQ(map.at(0.5, 0.245), none);
  EXPECT_EQ(map.at(0.05, 0.3), none);
  // Azimuth runs evenly along the horizon: ahead ends at 45 of 180 degrees.
  EXPECT_EQ(map.at(0.5 + 0.5 * 44 / 180, 0.5), ahead);
  EXPECT_EQ(map.at(0.5 + 0.5 * 46 / 180, 0.5), right);
  // Elevation 45, where ahead meets up: 2 theta + sin(2 theta) = pi sin(45) gives theta = 0.6334,
  // and y = sin(theta) = 0.592 of the half height.
  EXPECT_EQ(map.at(0.5, 0.5 - 0.25 * 0.584), ahead);
  EXPECT_EQ(map.at(0.5, 0.5 - 0.25 * 0.600), up);
}

TEST(Projection, LambertIsTheWholeSphereInADisc) {
  // Twice as wide as needed: the disc takes the middle half.
  const Map map(eye_of(six, six), Projection::lambert, 802, 401);
  const auto polar = [&](double angle_deg, double bearing_deg) {  // bearing from right upwards
    const double radius = std::sin(angle_deg * degree / 2);
    return map.at(0.5 + 0.25 * radius * std::cos(bearing_deg * degree),
                  0.5 - 0.5 * radius * std::sin(bearing_deg * degree));
  };
  EXPECT_EQ(polar(0, 0), ahead);
  EXPECT_EQ(polar(90, 0), right);
  EXPECT_EQ(polar(90, 180), left);
  EXPECT_EQ(polar(90, 90), up);
  EXPECT_EQ(polar(90, -90), down);
  for (int bearing = 0; bearing < 360; bearing += 15) EXPECT_EQ(polar(170, bearing), back);
  EXPECT_EQ(polar(44, 1), ahead);
  EXPECT_EQ(polar(46, 1), right);
  EXPECT_EQ(polar(134, 1), right);
  EXPECT_EQ(polar(136, 1), back);
  EXPECT_EQ(map.at(0.24, 0.5), none);
  EXPECT_EQ(map.at(0.26, 0.05), none);
}

TEST(Projection, HemispheresMeetAhead) {
  const Map map(eye_of(six, six), Projection::hemisphere, 802, 401);
  // Where the two discs meet is straight ahead, the far edges are straight behind.
  EXPECT_EQ(map.at(0.25, 0.5), left);
  EXPECT_EQ(map.at(0.498, 0.5), ahead);
  EXPECT_EQ(map.at(0.003, 0.5), back);
  EXPECT_EQ(map.at(0.25, 0.01), up);
  EXPECT_EQ(map.at(0.25, 0.99), down);
  EXPECT_EQ(map.at(0.75, 0.5), right);
  EXPECT_EQ(map.at(0.502, 0.5), ahead);
  EXPECT_EQ(map.at(0.997, 0.5), back);
  EXPECT_EQ(map.at(0.75, 0.01), up);
  EXPECT_EQ(map.at(0.75, 0.99), down);
  EXPECT_EQ(map.at(0.02, 0.02), none);
  EXPECT_EQ(map.at(0.5, 0.02), none);
  // 45 degrees from the middle is sin(22.5) / sin(45) = 0.5412 of the radius.
  EXPECT_EQ(map.at(0.75 - 0.25 * 0.53, 0.501), right);
  EXPECT_EQ(map.at(0.75 - 0.25 * 0.55, 0.501), ahead);
}

TEST(Projection, EachHemisphereHasItsOwnEye) {
  // Both eyes look ahead too; each disc shows its own eye's. The field ends where axes do: spaced
  // 60 degrees, the view of the left eye reaches 60 degrees beyond its last axis.
  const float c = std::cos(60 * static_cast<float>(degree)), s = std::sin(60 * float(degree));
  Eye eye = eye_of({{-1, 0, 0}, {-1, 0, 0}, {1, 0, 0}, {1, 0, 0}},
                   {{-s, 0, -c}, {0, 0, -1}, {s, 0, -c}, {0, 0, -1}});
  eye.eye_id = {4, 4, 2, 2};
  const Map map(eye, Projection::hemisphere, 401, 200);
  EXPECT_EQ(map.at(0.495, 0.5), 1);
  EXPECT_EQ(map.at(0.505, 0.5), 3);
  EXPECT_EQ(map.at(0.30, 0.5), 0);
  EXPECT_EQ(map.at(0.70, 0.5), 2);
  EXPECT_EQ(map.at(0.02, 0.5), none);
  EXPECT_EQ(map.at(0.98, 0.5), none);
}

TEST(Projection, VisualFieldsSideBySide) {
  // Axes 20 degrees apart: seven from ahead to the right, seven on the left from behind to ahead.
  std::vector<Vec3> axes, positions;
  const auto add = [&](double azimuth_deg, float x) {
    axes.push_back({static_cast<float>(std::sin(azimuth_deg * degree)), 0,
                    static_cast<float>(-std::cos(azimuth_deg * degree))});
    positions.push_back({x, 0.01f * static_cast<float>(axes.size()), 0});
  };
  for (int i = 0; i < 7; ++i) add(20 * i, 1);
  for (int i = 0; i < 7; ++i) add(-170 + 20 * i, -1);
  const Eye eye = eye_of(positions, axes, static_cast<float>(20 * degree));
  const auto ids = omma::side_by_side_ids(eye, 360, 181);
  ASSERT_EQ(ids.size(), 720u * 181u);
  const auto* horizon = &ids[90u * 720u];
  const auto* in_left = horizon + 180;  // by azimuth, the left eye's panel comes first
  const auto* in_right = horizon + 540;
  EXPECT_EQ(in_left[-175], 7);
  EXPECT_EQ(in_left[-50], 13);
  EXPECT_EQ(in_right[1], 0);
  EXPECT_EQ(in_right[119], 6);
  // The mean angle to the six nearest of an eye of seven is that to all the others: at the ends
  // (20 + ... + 120) / 6 = 70 degrees.
  EXPECT_EQ(in_left[-50 + 68], 13);
  EXPECT_EQ(in_left[-50 + 72], none);
  EXPECT_EQ(in_right[-68], 0);
  EXPECT_EQ(in_right[-72], none);
  // All eyes in one picture.
  const auto field = omma::field_ids(eye, 360, 181);
  ASSERT_EQ(field.size(), 360u * 181u);
  EXPECT_EQ(field[90u * 360u + 180u + 1u], 0);
  EXPECT_EQ(field[90u * 360u + 5u], 7);
  EXPECT_EQ(field[0], none);  // 90 degrees from all axes
  EXPECT_THROW(omma::field_ids(Eye{}, 8, 8), Error);
  EXPECT_THROW(omma::side_by_side_ids(eye, 0, 8), Error);
  EXPECT_THROW(omma::side_by_side_ids(eye, 1 << 29, 2), Error);
}

TEST(Projection, EqualAreaOnesGiveEachOmmatidiumItsSolidAngle) {
  // Axes on the horizon share the sphere in lunes, which are as large as they are wide. They end
  // halfway between the azimuths 0, 30, 90 and 200: at 15, 60, 145 and -80. The acceptance angle
  // lifts the limit of the field.
  std::vector<Vec3> axes;
  for (const double azimuth_deg : {0.0, 30.0, 90.0, 200.0})
    axes.push_back({static_cast<float>(std::sin(azimuth_deg * degree)), 0,
                    static_cast<float>(-std::cos(azimuth_deg * degree))});
  const Eye eye = eye_of(axes, axes, 4.0f);
  const double sphere[] = {95 / 360.0, 45 / 360.0, 85 / 360.0, 135 / 360.0};
  // A border of a few times 800 pixels is cut with an error that is random by pixel: well under
  // 100 of the 500,000 pixels.
  const double quantisation = 2e-4;
  for (const auto& map :
       {Map(eye, Projection::mollweide, 1200, 600), Map(eye, Projection::lambert, 800, 800)}) {
    const auto share = map.shares(0, map.width);
    ASSERT_EQ(share.size(), 4u);
    for (const auto& [id, part] : share)
      EXPECT_NEAR(part, sphere[static_cast<std::size_t>(id)], quantisation) << id;
  }
  // The right hemisphere is azimuth 0 to 180, the left one -180 to 0. This eye looks mostly right
  // and so is not shown on the left.
  const Map discs(eye_of(axes, axes, 4.0f), Projection::hemisphere, 1600, 800);
  const double half[] = {15 / 180.0, 45 / 180.0, 85 / 180.0, 35 / 180.0};
  for (const auto& [id, part] : discs.shares(800, 1600))
    EXPECT_NEAR(part, half[static_cast<std::size_t>(id)], quantisation) << id;
  EXPECT_TRUE(discs.shares(0, 800).empty());
  // The share of the picture that is the ellipse or the disc.
  const Ids ids = projection_ids(eye, Projection::mollweide, 1200, 600);
  const auto shown =
      ids.size() - static_cast<std::size_t>(std::count(ids.begin(), ids.end(), none));
  EXPECT_NEAR(static_cast<double>(shown) / static_cast<double>(ids.size()), omma::pi / 4, 1e-3);
}

TEST(Projection, Names) {
  std::set<Projection> different;
  for (const auto& [name, projection] : omma::named_projections()) {
    EXPECT_EQ(omma::projection_from_name(name), projection);
    EXPECT_EQ(omma::projection_from_name(std::string(name) + "_ids"), projection);
    different.insert(projection);
  }
  EXPECT_EQ(different.size(), omma::named_projections().size());
  for (const char* name : {"", "_ids", "Mollweide", "spherical", "facets_ids_ids"})
    EXPECT_THROW(omma::projection_from_name(name), Error) << name;
}

TEST(Projection, BadPicturesAreErrors) {
  const Eye eye = eye_of(six, six);
  for (const auto& named : omma::named_projections()) {
    EXPECT_THROW(projection_ids(eye, named.projection, 0, 10), Error) << named.name;
    EXPECT_THROW(projection_ids(eye, named.projection, 10, -1), Error) << named.name;
    EXPECT_THROW(projection_ids(eye, named.projection, 1 << 20, 1 << 20), Error) << named.name;
    EXPECT_THROW(projection_ids(Eye{}, named.projection, 10, 10), Error) << named.name;
    EXPECT_EQ(projection_ids(eye, named.projection, 6, 1).size(), 6u) << named.name;
  }
  EXPECT_THROW(projection_ids(eye_of({{1, 1, 1}, {1, 1, 1}}, {{0, 0, -1}, {1, 0, 0}}),
                              Projection::spherical_positionwise, 4, 2),
               Error);
}

TEST(Paint, IdsAreBigEndianInRgba) {
  const Ids ids = {0, 1, 0x01020304, 0x7fffffff, -1};
  EXPECT_EQ(omma::encode_ids(ids),
            (std::vector<std::uint8_t>{0, 0, 0,   0,   0,   0,   0,   1,   1,   2,
                                       3, 4, 127, 255, 255, 255, 255, 255, 255, 255}));
}

}  // namespace
