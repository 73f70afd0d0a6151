// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <memory>

#include <octet/converters/exr/slice_exr.h>
#include <octet/converters/picture/picture.h>
#include <octet/core/base/error.h>

#include "commands.h"
#include "console.h"

namespace octet::cli {
namespace {

struct Arguments {
  std::string input, output, levels = "auto", slice = "z", camera, range;
  std::optional<int> frame;
  AssetSubjectOptions asset;
  PictureOptions picture;
  SliceExrOptions exr;
  bool noLabels = false, noMesh = false, noSurface = false;
};

std::string extensionOf(const std::string& path) {
  std::string extension = std::filesystem::path(path).extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension;
}

/// A finite number, all of the text.
double parseNumber(const std::string& option, const std::string& text) {
  double x = 0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), x);
  if (status != std::errc() || end != text.data() + text.size() || !std::isfinite(x)) {
    throw InputError(option, "\"" + text + "\" is not a number");
  }
  return x;
}

std::vector<double> parseNumbers(const std::string& option, const std::string& text) {
  std::vector<double> numbers;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t comma = std::min(text.find(',', begin), text.size());
    numbers.push_back(parseNumber(option, text.substr(begin, comma - begin)));
    begin = comma + 1;
  }
  return numbers;
}

/// "z" or "z=0.5"
void parseSlice(const std::string& text, PictureOptions* picture) {
  const std::size_t axis = std::string("xyz").find(text.empty() ? '?' : text[0]);
  if (axis == std::string::npos || (text.size() > 1 && text[1] != '=')) {
    throw InputError("--slice", "\"" + text + "\" is not an axis, such as z, or z=0.5");
  }
  picture->axis = static_cast<int>(axis);
  if (text.size() > 1) picture->position = parseNumber("--slice", text.substr(2));
}

/// "azimuth,elevation" or "azimuth,elevation,zoom"
void parseCamera(const std::string& text, Camera* camera) {
  const std::vector<double> numbers = parseNumbers("--camera", text);
  if (numbers.size() != 2 && numbers.size() != 3) {
    throw InputError("--camera", "\"" + text + "\" is not AZIMUTH,ELEVATION or with a ,ZOOM");
  }
  camera->azimuth = numbers[0];
  camera->elevation = numbers[1];
  if (numbers.size() == 3) camera->zoom = numbers[2];
  if (std::abs(camera->elevation) > 90) throw InputError("--camera", "elevation is beyond 90");
  if (!(camera->zoom > 0)) throw InputError("--camera", "zoom is not positive");
}

void parseRange(const std::string& text, PictureOptions* picture) {
  const std::vector<double> numbers = parseNumbers("--range", text);
  if (numbers.size() != 2 || !(numbers[0] < numbers[1])) {
    throw InputError("--range", "\"" + text + "\" is not MIN,MAX");
  }
  picture->range = std::pair{numbers[0], numbers[1]};
}

Subject readSubject(Arguments& arguments, const Context& context) {
  if (extensionOf(arguments.input) == ".vdb") {
    return vdbSubject(arguments.input, arguments.asset.form);
  }
  const ControlAsset asset = readAsset(arguments.input);
  if (arguments.levels != "auto") {
    const double levels = parseNumber("--levels", arguments.levels);
    if (levels != std::floor(levels) || levels < 0 || levels > 12) {
      throw InputError("--levels", "\"" + arguments.levels + "\" is neither auto nor 0 to 12");
    }
    arguments.asset.levels = static_cast<int>(levels);
  }
  if (arguments.frame) {
    checkFrame(asset, *arguments.frame);
    arguments.asset.frame = *arguments.frame;
  } else if (const auto range = asset.frameRange()) {
    arguments.asset.frame = range->first;
  }
  return assetSubject(asset, arguments.asset, context);
}

/// An option that was given where it means nothing is a mistake.
void refuse(const CLI::App& command, std::initializer_list<const char*> options,
            const std::string& reason) {
  for (const char* option : options) {
    if (command.count(option) > 0) throw InputError(option, reason);
  }
}

void checkUse(const CLI::App& command, bool exr, PictureView view) {
  const bool slice = view == PictureView::Slice;
  if (!(exr && slice)) {
    refuse(command, {"--stack", "--atlas", "--rgb", "--layer"}, "is for slices in an .exr");
  }
  if (exr) {
    refuse(command, {"--title", "--no-labels"}, "is for .png; an .exr has no text");
    if (slice) {
      refuse(command, {"--style", "--range"}, "is for .png; a slice's .exr holds the numbers");
    }
  }
  if (slice) {
    refuse(command, {"--camera", "--count", "--cage", "--mesh-level", "--no-mesh", "--no-surface"},
           "is for --view 3d");
  } else {
    refuse(command, {"--slice", "--quantity", "--spacing"}, "is for slices");
  }
}

/// The same slice as numbers.
void setExr(const PictureOptions& picture, SliceExrOptions* exr) {
  exr->axis = picture.axis;
  exr->position = picture.position;
  exr->width = picture.width;
  exr->height = picture.height;
  exr->quantity = picture.quantity;
  exr->spacing = picture.spacing;
}

void run(const CLI::App& command, Arguments& arguments) {
  PictureOptions& picture = arguments.picture;
  picture.labels = !arguments.noLabels;
  picture.mesh = !arguments.noMesh;
  picture.surface = !arguments.noSurface;
  parseSlice(arguments.slice, &picture);
  if (!arguments.camera.empty()) parseCamera(arguments.camera, &picture.camera);
  if (!arguments.range.empty()) parseRange(arguments.range, &picture);
  arguments.output = outputPath(arguments.output, arguments.frame);
  const std::string extension = extensionOf(arguments.output);
  const bool exr = extension == ".exr";
  if (!exr && extension != ".png") {
    throw InputError("--output", "\"" + arguments.output + "\" ends neither in .png nor in .exr");
  }
  checkUse(command, exr, picture.view);
  const Context context = consoleContext();
  checkOutput(arguments.input, arguments.output);
  const Subject subject = readSubject(arguments, context.sub(0.5));
  if (exr && picture.view == PictureView::Slice) {
    setExr(picture, &arguments.exr);
    writeSliceExr(subject, arguments.exr, arguments.output, context);
  } else {
    writePicture(subject, picture, arguments.output, context);
  }
}

void addSubjectOptions(CLI::App* command, const std::shared_ptr<Arguments>& arguments) {
  AssetSubjectOptions& asset = arguments->asset;
  command->add_option("--form", asset.form,
                      "Form, or grid of a .vdb, by name; the first vector by default");
  command
      ->add_option("--levels", arguments->levels,
                   "Subdivisions; auto: as many as stay below 100,000 cells")
      ->capture_default_str();
  addBoundary(command, &asset.boundary, true);
  addWallSurface(command, &asset.wallSurface);
  addChoice(
      command, "--reconstruction", &asset.reconstruction, reconstructionChoices(),
      "limit: smooth, second order; whitney: Whitney forms on the finest level, in its own mesh");
  command->add_option("--frame", arguments->frame,
                      "Frame of an animated asset; the first by default");
  command->add_option("--zeta", asset.zeta, "Free weight of the octahedron's linear rule")
      ->capture_default_str();
}

void addPictureOptions(CLI::App* command, const std::shared_ptr<Arguments>& arguments) {
  PictureOptions& picture = arguments->picture;
  addChoice<PictureView>(command, "--view", &picture.view,
                         {{"slice", PictureView::Slice}, {"3d", PictureView::Solid}},
                         "A plane, or the whole in perspective");
  addChoice<PictureStyle>(
      command, "--style", &picture.style,
      {{"auto", PictureStyle::Automatic},
       {"plain", PictureStyle::Plain},
       {"lic", PictureStyle::Lic},
       {"arrows", PictureStyle::Arrows},
       {"streamlines", PictureStyle::Streamlines}},
      "Slices: plain, lic (line integral convolution), arrows; 3d: streamlines, "
      "arrows, or plain for the cage, mesh and surface alone");
  command->add_option("--slice", arguments->slice, "Axis, and place along it: z, or x=0.25")
      ->option_text("x|y|z[=POSITION]")
      ->capture_default_str();
  addChoice<Quantity>(command, "--quantity", &picture.quantity,
                      {{"magnitude", Quantity::Magnitude},
                       {"divergence", Quantity::Divergence},
                       {"curl", Quantity::Curl},
                       {"x", Quantity::X},
                       {"y", Quantity::Y},
                       {"z", Quantity::Z}},
                      "What a slice's colours show; a vector's magnitude, a scalar's value");
  command
      ->add_option("--spacing", picture.spacing,
                   "Distance to each side in the differences of divergence and curl, world "
                   "units; the mean edge or a voxel by default")
      ->check(CLI::PositiveNumber);
  command->add_option("--range", arguments->range, "Values at the ends of the colours")
      ->option_text("MIN,MAX");
  command->add_option("--width", picture.width, "Pixels")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command->add_option("--height", picture.height, "Pixels")
      ->check(CLI::Range(16, 16384))
      ->capture_default_str();
  command->add_option("--title", picture.title, "Title; the asset's and form's name by default");
  command->add_flag("--no-labels", arguments->noLabels, "No title and no numbers");
  command
      ->add_option("--camera", arguments->camera,
                   "Degrees around the up axis and above the horizon, and how much nearer")
      ->option_text("AZIMUTH,ELEVATION[,ZOOM]");
  command->add_option("--count", picture.count, "Streamlines or arrows of a 3d view, at most")
      ->check(CLI::Range(1, 100000));
  addChoice<CageLines>(
      command, "--cage", &picture.cage,
      {{"none", CageLines::None}, {"boundary", CageLines::Boundary}, {"all", CageLines::All}},
      "Which edges of the control mesh a 3d view draws");
  command
      ->add_option("--mesh-level", arguments->asset.meshLevel,
                   "Level whose boundary edges a 3d view draws")
      ->check(CLI::Range(0, 12))
      ->capture_default_str();
  command->add_flag("--no-mesh", arguments->noMesh, "Do not draw those edges");
  command->add_flag("--no-surface", arguments->noSurface, "Do not draw the boundary's surface");
}

void addExrOptions(CLI::App* command, SliceExrOptions* exr) {
  command->add_flag("--rgb", exr->rgb, "In an .exr, a vector as channels R G B");
  command->add_option("--layer", exr->layer, "In an .exr, a vector as channels LAYER.X .Y .Z")
      ->capture_default_str();
  command
      ->add_option("--stack", exr->stack,
                   "In an .exr, so many slices evenly through the domain, one part each")
      ->check(CLI::Range(1, 10000));
  command->add_flag("--atlas", exr->atlas, "In an .exr, the slices side by side in one image");
}

}  // namespace

void addPreview(CLI::App* program) {
  const auto arguments = std::make_shared<Arguments>();
  CLI::App* command = program->add_subcommand(
      "preview", "Draw a slice or a 3d view of a control asset's form or of a .vdb grid");
  command
      ->add_option("INPUT", arguments->input,
                   "Control asset (*.octet.json, *.octet), mesh, or .vdb by any program")
      ->required();
  command
      ->add_option("-o,--output", arguments->output,
                   "Picture to write, .png; or .exr: a slice as floats, a 3d view as light")
      ->required();
  addSubjectOptions(command, arguments);
  addPictureOptions(command, arguments);
  addExrOptions(command, &arguments->exr);
  command->callback([arguments, command] { run(*command, *arguments); });
}

}  // namespace octet::cli
