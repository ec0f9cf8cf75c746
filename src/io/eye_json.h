// What eye files say in JSON: angular sensitivities and receptor types. Used in the comment lines
// of CSV files and in the extras of OCES files.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "omma/acceptance.h"
#include "omma/receptor.h"

namespace omma {

// Names of kernels and of models of the rhabdom, in the order of their values.
extern const std::vector<std::string> acceptance_kernel_names;
extern const std::vector<std::string> rhabdom_model_names;

// Every field that is not as it is in a new one, so that reading gives back the same bits.
nlohmann::json acceptance_json(const Acceptance& acceptance);
nlohmann::json table_json(const SensitivityTable& table);
nlohmann::json receptor_type_json(const ReceptorType& type);

// Throw omma::Error that begins with `place` where a member is unknown or not what it should be.
// What the numbers mean is checked with the eye (validate_eye).
Acceptance read_acceptance(const nlohmann::json& object, const std::string& place);
SensitivityTable read_table(const nlohmann::json& object, const std::string& place);
ReceptorType read_receptor_type(const nlohmann::json& object, const std::string& place);

// Index of a name in a list; throws omma::Error that lists them.
std::size_t index_of_name(const std::vector<std::string>& names, const std::string& name,
                          const std::string& place);

}  // namespace omma
