// SPDX-License-Identifier: Apache-2.0
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <octet/converters/io/frames.h>
#include <octet/converters/picture/picture.h>
#include <octet/core/base/error.h>

#include "../../choices.h"
#include "errors.h"
#include "long_call.h"

namespace octet::python {
namespace {

/// The asset, or the .vdb of that name, as a picture's subject.
Subject subjectOf(const py::object& source, const std::string& form, std::optional<int> levels,
                  int frame, const Context& context) {
  if (py::isinstance<py::str>(source)) {
    const auto path = source.cast<std::string>();
    return withoutGil([&] { return vdbSubject(path, form); });
  }
  // The type belongs to the other module, so isinstance does not know it; a caster does.
  py::detail::make_caster<ControlAsset> caster;
  if (!caster.load(source, false)) {
    throw py::type_error("source is neither a ControlAsset nor a file name");
  }
  const auto& asset = py::detail::cast_op<const ControlAsset&>(caster);
  AssetSubjectOptions options;
  options.form = form;
  options.levels = levels;
  options.frame = frame;
  return withoutGil([&] { return assetSubject(asset, options, context); });
}

void preview(const py::object& source, const std::string& path, const std::string& form,
             const std::string& view, const std::string& style, const std::string& quantity,
             std::optional<int> levels, int frame, const std::string& axis,
             std::optional<double> position, int width, int height, bool labels,
             const py::object& progress) {
  PictureOptions options;
  options.view = choose<PictureView>("view", view,
                                     {{"slice", PictureView::Slice}, {"3d", PictureView::Solid}});
  options.style = choose<PictureStyle>("style", style,
                                       {{"auto", PictureStyle::Automatic},
                                        {"plain", PictureStyle::Plain},
                                        {"lic", PictureStyle::Lic},
                                        {"arrows", PictureStyle::Arrows},
                                        {"streamlines", PictureStyle::Streamlines}});
  options.quantity = choose<Quantity>("quantity", quantity,
                                      {{"auto", Quantity::Automatic},
                                       {"magnitude", Quantity::Magnitude},
                                       {"divergence", Quantity::Divergence},
                                       {"curl", Quantity::Curl},
                                       {"x", Quantity::X},
                                       {"y", Quantity::Y},
                                       {"z", Quantity::Z}});
  options.axis = choose<int>("axis", axis, {{"x", 0}, {"y", 1}, {"z", 2}});
  options.position = position;
  if (width < 16 || width > 16384 || height < 16 || height > 16384) {
    throw InputError("width, height", "are not from 16 to 16384");
  }
  options.width = width;
  options.height = height;
  options.labels = labels;
  const Context context = contextOf(progress);
  const Subject subject = subjectOf(source, form, levels, frame, context.sub(0.5));
  const std::string file = outputAt(path, frame);
  withoutGil([&] { writePicture(subject, options, file, context); });
}

}  // namespace
}  // namespace octet::python

namespace py = pybind11;

/// A module of its own: drawing needs libraries that baking does not.
PYBIND11_MODULE(_pictures, module) {
  module.doc() = "The part of octetvdb that draws.";
  // Beside this one in its package, under whatever name the package was imported.
  const auto name = module.attr("__name__").cast<std::string>();
  octet::python::useErrors(
      py::module_::import((name.substr(0, name.rfind('.')) + "._octetvdb").c_str()));
  module.def("preview", &octet::python::preview, py::arg("source"), py::arg("path"), py::kw_only(),
             py::arg("form") = "", py::arg("view") = "slice", py::arg("style") = "auto",
             py::arg("quantity") = "auto", py::arg("levels") = py::none(), py::arg("frame") = 0,
             py::arg("axis") = "z", py::arg("position") = py::none(), py::arg("width") = 1280,
             py::arg("height") = 720, py::arg("labels") = true, py::arg("progress") = py::none(),
             R"(Draws a slice or a 3d view of a form or grid, as a PNG.

source:   a ControlAsset, or the name of a .vdb by any program
path:     the .png to write, "####" in its name means the frame; appears complete or not at all
form:     name of the form or grid; the first vector by default
view:     "slice" or "3d"
style:    "auto"; slices: "plain", "lic", "arrows"; 3d: "plain", "arrows", "streamlines"
quantity: a slice's colours: "auto", "magnitude", "divergence", "curl", "x", "y", "z"
levels:   subdivisions; None: as many as stay below 100,000 cells
frame:    of an animated form
axis:     a slice's: "x", "y", "z"
position: along it, world units; None: the middle
width, height: pixels
labels:   title and numbers
progress: called as progress(stage, done, total, unit); returning False raises Cancelled
Releases the GIL. Raises InputError, IoError, Cancelled.)");
}
