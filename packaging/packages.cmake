# Debian packages, by `./dev package`: dependencies from the files themselves (dpkg-shlibdeps), and what each must have
# by Debian's policy: copyright, changelog, manual page.
set(library_package libplumbline${PROJECT_VERSION_MAJOR}.${PROJECT_VERSION_MINOR})
set(PLUMBLINE_CONTACT "Plumbline <plumbline@example.org>" CACHE STRING "Maintainer of the Debian packages")
set(debian_version ${PROJECT_VERSION}-1)

# NAME of a COMPONENT's package, its section, and what it holds, in lines of at most 78 characters.
function(plumbline_package component name section text)
  string(TOUPPER ${component} COMPONENT)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_NAME ${name} PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_PACKAGE_SECTION ${section} PARENT_SCOPE)
  set(CPACK_DEBIAN_${COMPONENT}_DESCRIPTION "${about}\n${text}" PARENT_SCOPE)
  set(documents ${CMAKE_CURRENT_BINARY_DIR}/documents)
  install(FILES ${documents}/copyright ${documents}/changelog.Debian.gz DESTINATION ${CMAKE_INSTALL_DATADIR}/doc/${name}
    COMPONENT ${component} OPTIONAL)
endfunction()

set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "dense 3D reconstruction from a depth camera")
set(about "Plumbline makes a camera trajectory and a mesh from depth images, on an\nordinary CPU, with or without an orientation sensor (KinectFusion family).")
plumbline_package(program plumbline science "This is the program.")
plumbline_package(library ${library_package} libs "This is the shared library.")
plumbline_package(development libplumbline-dev libdevel
  "These are the headers, the static library, the CMake package and the\npkg-config modules.")
plumbline_package(python python3-plumbline python "This is the Python module.")

file(READ debian/copyright copyright)
file(CONFIGURE OUTPUT documents/copyright CONTENT "${copyright}" @ONLY)
string(TIMESTAMP date "%a, %d %b %Y 00:00:00 +0000" UTC)
file(CONFIGURE OUTPUT documents/changelog.Debian @ONLY CONTENT
"plumbline (${debian_version}) unstable; urgency=medium

  * Version ${PROJECT_VERSION}: see CHANGELOG.md of the sources.

 -- ${PLUMBLINE_CONTACT}  ${date}
")
find_program(GZIP gzip)
if(GZIP)
  execute_process(COMMAND ${GZIP} -9nfk documents/changelog.Debian WORKING_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR})
endif()

set(CPACK_GENERATOR DEB)
set(CPACK_PACKAGE_NAME plumbline)
set(CPACK_PACKAGE_VENDOR Plumbline)
set(CPACK_PACKAGE_CONTACT "${PLUMBLINE_CONTACT}")
set(CPACK_PACKAGE_DIRECTORY ${PROJECT_BINARY_DIR}/packages)
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_ALL program library development)
if(TARGET plumbline_python)
  list(APPEND CPACK_COMPONENTS_ALL python)
endif()
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_DEBIAN_PACKAGE_RELEASE 1)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_GENERATE_SHLIBS ON)
set(CPACK_DEBIAN_LIBRARY_PACKAGE_CONTROL_EXTRA ${CMAKE_CURRENT_SOURCE_DIR}/debian/triggers)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SHLIBDEPS OFF)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS "${library_package} (= ${debian_version}), libeigen3-dev (>= 3.4)")
# What the static library is linked with besides.
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "libceres-dev, libembree-dev, libfmt-dev, libtbb-dev, libtomlplusplus-dev, libspng-dev, libturbojpeg0-dev, libtiff-dev, libopenexr-dev, zlib1g-dev, libbz2-dev, liblz4-dev, libzstd-dev, libsqlite3-dev, libcurl4-openssl-dev, libarchive-dev, libssl-dev, libmatroska-dev, libebml-dev, pkg-config")
set(CPACK_DEBIAN_PROGRAM_PACKAGE_SUGGESTS "gnuplot-nox")
set(CPACK_DEBIAN_PYTHON_PACKAGE_DEPENDS "python3 (>= 3.11), python3 (<< 3.12), python3-numpy")
include(CPack)
