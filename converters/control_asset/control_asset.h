// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>

#include <octet/core/forms/cochain.h>
#include <octet/core/topology/control_mesh.h>

namespace octet {

/// No frame is farther from 0, before or after.
inline constexpr int kLastFrame = 9999999;

/// A form of a control asset: coefficients on some simplices, the others are 0; constant or one
/// set per frame. `simplices` are dense indices into the control complex and `signs` tell whether
/// the asset lists them along the stored orientation.
struct Form {
  std::string name;
  int degree = 0;
  std::string unit;
  std::vector<Index> simplices;
  std::vector<std::int8_t> signs;
  std::vector<double> values;                 ///< one per simplex; unused when there are frames
  std::map<int, std::vector<double>> frames;  ///< by frame number

  bool animated() const { return !frames.empty(); }
};

/// What a scene says about units, kept from the file to the grids.
struct AssetUnits {
  char upAxis = 'Z';  ///< 'Y' or 'Z'
  double metersPerUnit = 1.0;
  double framesPerSecond = 24.0;
};

/// @brief A control asset: a control mesh with forms on it, the input of everything
/// (converters/README.md, "Control asset").
struct ControlAsset {
  std::string name;
  AssetUnits units;
  ControlMesh mesh;
  std::vector<Form> forms;

  /// The form of that name; throws InputError listing the names there are.
  const Form& form(const std::string& name) const;
  /// First and last frame number over all animated forms; none when all are constant.
  std::optional<std::pair<int, int>> frameRange() const;
};

/// Reads `*.octet.json` or the same document as CBOR (`*.octet`).
/// @throws InputError with the file, the place and the reason.
ControlAsset readControlAsset(const std::string& path);

/// Writes a control asset, as CBOR when the name ends in `.octet`. The file appears complete or not
/// at all. @throws IoError, Cancelled
void writeControlAsset(const ControlAsset& asset, const std::string& path,
                       const Context& context = {});

/// Coefficients of a form of degree K on the control mesh. A frame that the form lacks takes the
/// nearest earlier one (the first, before all); `frame` is ignored for a constant form.
template <int K>
Cochain<K> coefficients(const ControlAsset& asset, const Form& form, int frame = 0);

/// Makes a form from dense coefficients, listing those that are not 0.
template <int K>
Form makeForm(std::string name, const Cochain<K>& coefficients, std::string unit = "");

}  // namespace octet
