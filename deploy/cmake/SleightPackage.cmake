# Debian's package of what is installed: `cmake --preset package && cmake --build --preset package`, then
# `cpack --preset package` puts sleight_*.deb into build/package. `deploy/soak packages` judges it with
# lintian, and installs and upgrades it in a Debian 12 of its own.
#
# What a package needs beyond programs lies in deploy/systemd and deploy/debian.

install(FILES deploy/systemd/sleightd.service DESTINATION lib/systemd/system)
install(FILES deploy/systemd/sysusers.conf DESTINATION lib/sysusers.d RENAME sleight.conf)
install(FILES LICENSE DESTINATION share/doc/sleight RENAME copyright)
install(FILES deploy/debian/lintian-overrides DESTINATION share/lintian/overrides RENAME sleight)

execute_process(COMMAND ${CMAKE_SOURCE_DIR}/deploy/version --release ${PROJECT_VERSION}
  OUTPUT_VARIABLE version OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
set(CPACK_PACKAGE_NAME sleight)
set(CPACK_PACKAGE_VENDOR "The Sleight authors")
set(CPACK_PACKAGE_CONTACT "The Sleight authors <sleight@localhost.localdomain>")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_PRE_BUILD_SCRIPTS ${CMAKE_SOURCE_DIR}/deploy/cmake/debian_files.cmake)
set(CPACK_DEBIAN_PACKAGE_VERSION ${version})
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
# Below the project's own line.
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"One says how a chaotic motion must end (this die shows a six there, these
marbles spell a word) and Sleight finds many different animations that end
so and are plausible: on one machine, by mpirun on many, or as a service.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# mpirun is for --ranks alone; systemd brings systemd-sysusers.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, fonts-dejavu-core")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "openmpi-bin")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${CMAKE_SOURCE_DIR}/deploy/debian/postinst ${CMAKE_SOURCE_DIR}/deploy/debian/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
