# SPDX-License-Identifier: Apache-2.0
# Debian packages: cmake --preset packages && cmake --build --preset packages (then build/packages/*.deb).
# The command, octetvdb-gmsh (which alone is under the GPL), the library with its headers, the Python
# module for the system's Python, and the add-on where the system's Blender finds it.
set(OCTETVDB_COMPONENTS command gmsh library python blender)
set(package_of_command octetvdb)
set(package_of_gmsh octetvdb-gmsh)
set(package_of_library liboctetvdb-dev)
set(package_of_python python3-octetvdb)
set(package_of_blender blender-octetvdb)
if(NOT OCTETVDB_WITH_GMSH)
  list(REMOVE_ITEM OCTETVDB_COMPONENTS gmsh)
endif()

foreach(component IN LISTS OCTETVDB_COMPONENTS)
  set(licence ${PROJECT_SOURCE_DIR}/LICENSE)
  if(component STREQUAL gmsh)
    set(licence ${PROJECT_SOURCE_DIR}/converters/gmsh/program/COPYING)
  endif()
  install(FILES ${licence} RENAME copyright COMPONENT ${component}
    DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${package_of_${component}})
endforeach()
# Assets to try it with, and what farms need.
install(FILES samples/box/box.octet.json samples/animated/animated.octet.json
  DESTINATION ${CMAKE_INSTALL_DATADIR}/octetvdb/samples COMPONENT command)
install(DIRECTORY samples/farm DESTINATION ${CMAKE_INSTALL_DATADIR}/octetvdb/samples
  USE_SOURCE_PERMISSIONS COMPONENT command)

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_CONTACT "The OctetVDB authors <octetvdb@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_COMPONENTS_ALL ${OCTETVDB_COMPONENTS})
set(CPACK_STRIP_FILES ON)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SECTION graphics)
foreach(component IN LISTS OCTETVDB_COMPONENTS)
  string(TOUPPER ${component} upper)
  set(CPACK_DEBIAN_${upper}_PACKAGE_NAME ${package_of_${component}})
endforeach()

set(CPACK_DEBIAN_COMMAND_DESCRIPTION "Exactly incompressible velocity fields, baked to OpenVDB
 The command octetvdb, with its man page and completion for bash.")
set(CPACK_DEBIAN_COMMAND_PACKAGE_RECOMMENDS octetvdb-gmsh)

set(CPACK_DEBIAN_GMSH_DESCRIPTION "Tetrahedra for octetvdb
 The program that reads and makes tetrahedral meshes for octetvdb, with Gmsh and CGAL.")
if(OCTETVDB_WITH_GMSH)  # it loads Gmsh while it runs
  file(REAL_PATH ${GMSH_LIBRARY} file)
  execute_process(COMMAND dpkg-query --search ${file} OUTPUT_VARIABLE owner ERROR_QUIET)
  string(REGEX MATCH "^[^:]+" owner "${owner}")
  set(CPACK_DEBIAN_GMSH_PACKAGE_DEPENDS ${owner})
endif()

set(CPACK_DEBIAN_LIBRARY_DESCRIPTION "The library below octetvdb
 Headers, static libraries and a CMake package, OctetVDB.")
set(CPACK_DEBIAN_LIBRARY_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS
  "libeigen3-dev, libtbb-dev, libopenvdb-dev, libboost-iostreams-dev, libassimp-dev")
if(OCTETVDB_WITH_PICTURES)
  string(APPEND CPACK_DEBIAN_LIBRARY_PACKAGE_DEPENDS
    ", libembree-dev, libopenexr-dev, libcairo2-dev")
endif()

math(EXPR next "${Python_VERSION_MINOR} + 1")
set(CPACK_DEBIAN_PYTHON_DESCRIPTION "The Python module octetvdb
 Exactly incompressible velocity fields, authored with numpy and baked to OpenVDB.")
set(CPACK_DEBIAN_PYTHON_PACKAGE_SECTION python)
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS
  "python3 (>= 3.${Python_VERSION_MINOR}), python3 (<< 3.${next}), python3-numpy")
set(CPACK_DEBIAN_PYTHON_PACKAGE_RECOMMENDS octetvdb-gmsh)

set(CPACK_DEBIAN_BLENDER_DESCRIPTION "OctetVDB's add-on for Blender
 In Edit > Preferences > Add-ons, where it can be enabled.")
set(CPACK_DEBIAN_BLENDER_PACKAGE_ARCHITECTURE all)
set(CPACK_DEBIAN_BLENDER_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_BLENDER_PACKAGE_DEPENDS "blender, python3-octetvdb (>= ${PROJECT_VERSION})")
include(CPack)
