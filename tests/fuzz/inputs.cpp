// SPDX-License-Identifier: Apache-2.0
#include "inputs.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include <octet/converters/control_asset/control_asset.h>
#include <octet/core/base/error.h>
#include <octet/core/field/field.h>
#ifdef OCTETVDB_WITH_GMSH
#include <octet/converters/gmsh/file_check.h>
#include <octet/converters/gmsh/gmsh_import.h>
#endif

namespace octet::fuzz {
namespace {

namespace fs = std::filesystem;

/// Larger meshes are read but not refined.
constexpr Index kMostCells = 500;

void promise(bool kept, const char* what) {
  if (kept) return;
  std::fprintf(stderr, "broken promise: %s\n", what);
  std::abort();
}

/// A folder of this process for inputs and outputs.
class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("octet-fuzz-" + std::to_string(::getpid()))) {
    fs::create_directory(path_);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  std::string file(const std::string& name) const { return path_ / name; }
  std::string write(const std::string& name, const std::uint8_t* data, std::size_t size) const {
    std::ofstream out(file(name), std::ios::binary);
    out.write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));
    return file(name);
  }

 private:
  fs::path path_;
};

const Folder& folder() {
  static const Folder instance;
  return instance;
}

template <int K>
void useForm(const ControlAsset& asset, const Form& form, const Refiner& refiner,
             const Limit& limit) {
  for (const BoundaryMode mode : {BoundaryMode::Walls, BoundaryMode::Open}) {
    const int frame = form.animated() ? form.frames.rbegin()->first : 0;
    const Cochain<K> fine = refiner.refine(coefficients<K>(asset, form, frame), mode);
    for (const double x : fine.values()) promise(std::isfinite(x), "coefficients are finite");
    const auto field = makeField<K>(refiner, limit, fine, mode);
    typename Piece<kComponents<K>>::Value value;
    const Vec3 middle = (field.bounds().min + field.bounds().max) / 2;
    if (field.sample(middle, &value)) promise(value.allFinite(), "samples are finite");
  }
}

void useForm(const ControlAsset& asset, const Form& form, const Refiner& refiner,
             const Limit& limit) {
  switch (form.degree) {
    case 0:
      return useForm<0>(asset, form, refiner, limit);
    case 1:
      return useForm<1>(asset, form, refiner, limit);
    case 2:
      return useForm<2>(asset, form, refiner, limit);
    default:
      return useForm<3>(asset, form, refiner, limit);
  }
}

void expectSame(const ControlAsset& a, const ControlAsset& b) {
  promise(a.mesh.positions().size() == b.mesh.positions().size(), "vertices survive writing");
  for (std::size_t k = 0; k < a.mesh.positions().size(); ++k) {
    promise(a.mesh.positions()[k] == b.mesh.positions()[k], "positions survive writing");
  }
  promise(a.mesh.complex()->tets == b.mesh.complex()->tets, "tetrahedra survive writing");
  promise(a.mesh.complex()->octs == b.mesh.complex()->octs, "octahedra survive writing");
  promise(a.forms.size() == b.forms.size(), "forms survive writing");
  for (std::size_t k = 0; k < a.forms.size(); ++k) {
    const Form &f = a.forms[k], &g = b.forms[k];
    promise(f.name == g.name && f.degree == g.degree && f.unit == g.unit, "forms survive writing");
    promise(f.simplices == g.simplices && f.signs == g.signs, "simplices survive writing");
    promise(f.values == g.values && f.frames == g.frames, "values survive writing");
  }
}

}  // namespace

bool tryAsset(const std::uint8_t* data, std::size_t size) {
  const std::string path = folder().write("input.octet", data, size);
  ControlAsset asset;
  try {
    asset = readControlAsset(path);
  } catch (const InputError& e) {
    promise(e.file() == path && !e.reason().empty(), "errors tell the file and the reason");
    return false;
  }
  for (const char* name : {"again.octet", "again.octet.json"}) {
    writeControlAsset(asset, folder().file(name));
    expectSame(asset, readControlAsset(folder().file(name)));
  }
  if (asset.mesh.complex()->cellCount() > kMostCells) return true;
  const Refiner refiner(asset.mesh);
  const Limit limit(refiner);
  for (const Form& form : asset.forms) useForm(asset, form, refiner, limit);
  return true;
}

#ifdef OCTETVDB_WITH_GMSH
bool tryMeshCheck(const char* extension, const std::uint8_t* data, std::size_t size) {
  const std::string path = folder().write(std::string("input") + extension, data, size);
  try {
    gmsh_import::checkMeshFile(path);
    return true;
  } catch (const InputError&) {
    return false;
  }
}

bool tryMesh(const char* extension, const std::uint8_t* data, std::size_t size) {
  const std::string path = folder().write(std::string("input") + extension, data, size);
  try {
    const ControlAsset asset = readGmshMesh(path);
    writeControlAsset(asset, folder().file("again.octet"));
    expectSame(asset, readControlAsset(folder().file("again.octet")));
    return true;
  } catch (const InputError& e) {
    promise(e.file() == path && !e.reason().empty(), "errors tell the file and the reason");
    return false;
  }
}
#endif

}  // namespace octet::fuzz
