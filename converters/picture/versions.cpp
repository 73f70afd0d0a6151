// SPDX-License-Identifier: Apache-2.0
#include "versions.h"

#include <OpenEXR/ImfVersion.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <cairo.h>

#include "embree.h"

namespace octet {

std::vector<std::pair<std::string, std::string>> pictureLibraryVersions() {
  return {{"cairo", cairo_version_string()},
          {"embree", RTC_VERSION_STRING},
          {"openexr", OPENEXR_VERSION_STRING}};
}

}  // namespace octet
