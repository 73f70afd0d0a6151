// SPDX-License-Identifier: Apache-2.0
// A flow that follows a guide curve, without divergence and without a way through the walls.
// Arguments: samples/box/box.octet.json out.octet.json
#include <cmath>
#include <cstdio>

#include <octet/converters/api.h>
#include <octet/core/api.h>

int main(int, char** argv) {
  octet::ControlAsset asset = octet::readControlAsset(argv[1]);

  // A ring in the middle of the box, along which the flow is to run with one unit per second.
  octet::GuideCurve ring;
  ring.name = "ring";
  ring.speeds = {1.0};
  constexpr int kPoints = 48;
  for (int k = 0; k <= kPoints; ++k) {
    const double angle = 2 * M_PI * (k % kPoints) / kPoints;
    ring.points.push_back({0.5 * std::cos(angle), 0.5 * std::sin(angle), 0});
  }

  const octet::Fit fit(asset.mesh);  // made once, solved for any guides
  const octet::FitResult result = fit.solve({{ring}, {}});
  std::printf("the ring is missed by less than 5 %%: %s\n",
              result.report.residual < 0.05 ? "yes" : "no");
  std::printf("flow through the walls: %g\n", result.report.wallFlux);

  asset.forms = {octet::makeForm<2>("velocity", *result.flux, "1/s")};
  octet::writeControlAsset(asset, argv[2]);
  std::printf("%zu form written\n", octet::readControlAsset(argv[2]).forms.size());
}
