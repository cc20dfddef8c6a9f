# The Debian package: `cmake --preset package && cmake --build --preset package`, then `cpack --preset package`
# writes sleight_*.deb to build/package. `deploy/soak packages` checks it with lintian, and installs and upgrades
# it in a fresh Debian 12.
#
# Files of the package other than programs are in deploy/systemd and deploy/debian.

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
# The project's description is the first line; this text follows.
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION
"Specify how a chaotic motion must end (this die shows a six there, these
marbles spell a word), and Sleight finds many different, plausible animations
that end that way: on one machine, under mpirun, or as a service.")
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
# Only --ranks needs mpirun. systemd includes systemd-sysusers.
set(CPACK_DEBIAN_PACKAGE_DEPENDS "systemd, fonts-dejavu-core")
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS "openmpi-bin")
set(CPACK_DEBIAN_PACKAGE_SUGGESTS "ffmpeg")
set(CPACK_DEBIAN_PACKAGE_CONTROL_EXTRA
  ${CMAKE_SOURCE_DIR}/deploy/debian/postinst ${CMAKE_SOURCE_DIR}/deploy/debian/prerm)
set(CPACK_DEBIAN_PACKAGE_CONTROL_STRICT_PERMISSION ON)
include(CPack)
