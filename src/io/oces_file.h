// What the readers of OCES files share: the open file, checked access to its JSON, the values of
// ommatidial properties, and the places of ommatidia.
#pragma once

#include <array>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "io/gltf_accessor.h"
#include "io/gltf_container.h"
#include "omma/eye.h"
#include "omma/scene.h"
#include "omma/vec.h"

namespace omma {

// Names of properties in which Omma keeps what the standard has no place for. In the eye's frame.
namespace oces_name {
inline constexpr const char* acceptance_angle = "OMMA_ACCEPTANCE_ANGLE";    // rad
inline constexpr const char* focal_offset = "OMMA_FOCAL_OFFSET";            // m
inline constexpr const char* facet_diameter = "OMMA_FACET_DIAMETER";        // m
inline constexpr const char* aperture_diameter = "OMMA_APERTURE_DIAMETER";  // m
inline constexpr const char* up = "OMMA_UP";
inline constexpr const char* acceptance = "OMMA_ACCEPTANCE";  // number in the list, 0 for none
inline constexpr const char* index = "OMMA_INDEX";            // of the ommatidium in the head
inline constexpr const char* eye_name_column = "eye_name";
}  // namespace oces_name

// Beyond this half angle (rad) the tangent says nothing; an acceptance angle that is wider is
// written as twice it.
inline constexpr double oces_widest_half_angle = 1.55;

// The acceptance angle of a facet and the distance of its focal point.
double oces_acceptance_rad(double diameter_m, double distance_m);

struct OcesImage {
  int width = 0, height = 0;
  std::vector<float> rgba;  // [height][width][4], as stored, 0 to 1
  Texture sampling;
  bool grey = false;
};

struct OcesFile {
  GltfContainer gltf;
  std::map<int, OcesImage> images;  // by texture, once read
  std::map<int, Eye> eyes;          // by number in the list, once read
  // Of Omma's own extras, for all eyes.
  std::vector<Acceptance> acceptances;
  std::vector<ReceptorType> receptor_types;
  const nlohmann::json& extension() const;
};

// Members of JSON objects; each throws omma::Error that begins with `place` where a member is not
// what it should be.
const nlohmann::json* oces_member(const nlohmann::json& object, const char* name);
bool oces_flag(const nlohmann::json& object, const char* name, bool otherwise,
               const std::string& place);
std::string oces_text(const nlohmann::json& object, const char* name, const std::string& place);
double oces_number(const nlohmann::json& value, const std::string& place);
// An index into a list of `count`; `what` names the list.
int oces_index(const nlohmann::json& value, std::size_t count, const char* what,
               const std::string& place);
// Element `index` of a list of the extension.
const nlohmann::json& oces_element(const OcesFile& file, const char* list,
                                   const nlohmann::json& index, const std::string& place);
// Omma's own extras of an object of the extension; an empty object where there are none.
const nlohmann::json& oces_extras(const nlohmann::json& object);

// Where an ommatidium is, and where its properties are read: from three vertices (or ommatidia)
// with weights, or from a texture.
struct OcesSite {
  Vec3d position_m, normal;  // in the eye's frame
  std::array<std::uint32_t, 3> vertex{};
  std::array<double, 3> weight{1, 0, 0};
  double u = 0, v = 0;  // texture coordinates
};

struct OcesProperty {
  std::string place;  // for errors
  std::size_t components = 1;
  bool coarse = false;
  std::vector<double> values;  // [element][component]; one element where coarse
  const OcesImage* image = nullptr;
  std::array<double, 4> center{}, scale{1, 1, 1, 1};
};

// `elements` that an accessor must have, 0 for any; textures only where allowed.
OcesProperty read_oces_property(OcesFile& file, const nlohmann::json& index, bool allows_accessor,
                                bool allows_texture, const std::string& place);
std::size_t oces_element_count(const OcesProperty& property);
// The components at a site, into `out`.
void oces_value(const OcesProperty& property, const OcesSite& site, double* out);
double oces_scalar(const OcesProperty& property, const OcesSite& site);

// The elements of an accessor as numbers, with what it says of itself.
std::vector<double> read_oces_accessor(OcesFile& file, const nlohmann::json& index,
                                       GltfAccessor& accessor, const std::string& place);

using OcesProperties = std::map<std::string, OcesProperty>;

// `count` sites on a surface or a sphere, as far from one another as they can be where distances
// count in diameters of facets: the local spacing follows DIAMETER. The same each time.
std::vector<OcesSite> oces_surface_sites(OcesFile& file, const nlohmann::json& eye,
                                         const OcesProperties& properties,
                                         const std::string& place);
std::vector<OcesSite> oces_sphere_sites(const nlohmann::json& eye, const OcesProperties& properties,
                                        const std::string& place);

// One entry of the list of eyes, in its own frame (OCES's, not ours), not placed.
Eye read_oces_eye(OcesFile& file, const nlohmann::json& eye, const std::string& place);

}  // namespace omma
