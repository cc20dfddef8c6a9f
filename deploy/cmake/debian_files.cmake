# Runs before the package is packed: writes a changelog, and compresses it and the manual pages, as Debian requires.
find_program(GZIP gzip REQUIRED)
file(GLOB pages ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/share/man/man*/*.[0-9])
set(changelog ${CPACK_TEMPORARY_INSTALL_DIRECTORY}/usr/share/doc/sleight/changelog.gz)
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
string(REGEX REPLACE "[.]gz$" "" plain ${changelog})
file(WRITE ${plain} "sleight (${CPACK_DEBIAN_PACKAGE_VERSION}) bookworm; urgency=medium

  * Built from the commit in the version. For changes, see that commit's history.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
execute_process(COMMAND ${GZIP} -9nf ${pages} ${plain} COMMAND_ERROR_IS_FATAL ANY)
