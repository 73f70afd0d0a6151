// SPDX-License-Identifier: Apache-2.0
// consumer ASSET OUT.vdb [MESH]: reads, refines and bakes with the installed libraries, as its
// users would, and prints what it made.
#include <exception>
#include <iostream>

#include <octet/converters/api.h>
#include <octet/core/api.h>
#include <octet/version.h>

int main(int argc, char** argv) {
  try {
    const octet::ControlAsset asset = octet::readControlAsset(argv[1]);
    const octet::Refiner refiner(asset.mesh);
    const octet::Limit limit(refiner);
    const octet::Form& form = asset.form("velocity");
    const auto fine =
        refiner.refine(octet::coefficients<2>(asset, form), octet::BoundaryMode::Walls);
    const auto field = octet::makeField(refiner, limit, fine, octet::BoundaryMode::Walls);
    octet::Piece<3>::Value velocity;
    const bool inside = field.sample(octet::Vec3(0.3, 0.1, 0.2), &velocity);

    octet::BakeOptions options;
    options.resolution = 16;
    const octet::BakeReport report = octet::bake(asset, options, argv[2]);
    std::cout << octet::kVersion << " " << inside << " " << velocity.norm() << " "
              << report.files.at(0).grids.size() << "\n";
    if (argc > 3) std::cout << octet::readGmshMesh(argv[3]).forms.size() << "\n";
  } catch (const std::exception& e) {
    std::cerr << e.what() << "\n";
    return 1;
  }
}
