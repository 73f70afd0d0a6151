// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "camera.h"
#include "colour_map.h"
#include "slice.h"

namespace octet {

enum class PictureView : std::uint8_t {
  Slice,  ///< a plane across an axis
  Solid,  ///< the whole domain in perspective
};

/// What is drawn besides colours.
enum class PictureStyle : std::uint8_t {
  Automatic,  ///< plain in a slice; streamlines of a vector, else plain, of the whole
  Plain,      ///< nothing: colours only; of the whole, the surface in a scalar's colours
  Lic,        ///< line integral convolution; slices
  Arrows,
  Streamlines,  ///< of the whole
};

enum class CageLines : std::uint8_t { None, Boundary, All };

/// @brief All that a picture can be asked for. Sizes are in pixels, positions and distances in
/// world units. The same options give the same bytes, at any number of threads.
struct PictureOptions {
  PictureView view = PictureView::Slice;
  PictureStyle style = PictureStyle::Automatic;
  int width = 1280, height = 720;
  bool labels = true;                                ///< title and numbers
  std::string title;                                 ///< empty: made from the subject
  std::optional<std::pair<double, double>> range{};  ///< of colours; absent: of what is drawn

  // Slices.
  int axis = 2;
  std::optional<double> position{};  ///< absent: the middle
  Quantity quantity = Quantity::Automatic;
  double spacing = 0;  ///< of differences; 0: the subject's detail

  // The whole.
  Camera camera{};
  std::size_t count = 0;  ///< of streamlines or arrows; 0: automatic
  CageLines cage = CageLines::Boundary;
  bool mesh = true;
  bool surface = true;
};

/// Draws a picture and writes it as PNG; a 3d view also as OpenEXR, when the name ends in .exr:
/// linear light R G B A, without background, title and colour bar. Complete or not at all. Float
/// slices: slice_exr.h.
/// @throws InputError, IoError, Cancelled
void writePicture(const Subject& subject, const PictureOptions& options, const std::string& path,
                  const Context& context = {});

/// The range of colours that some values ask for: from 0 for what has a size, symmetric for what
/// has a sign, else from the least to the greatest.
ColourScale colourScale(const Subject& subject, const PictureOptions& options,
                        const std::vector<double>& values);

/// "vortex: velocity", or the title asked for.
std::string pictureTitle(const Subject& subject, const PictureOptions& options);

/// "|velocity|", "div velocity", "velocity.x".
std::string quantityLabel(const Subject& subject, Quantity quantity);

}  // namespace octet
