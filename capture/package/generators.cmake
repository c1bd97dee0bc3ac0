# SPDX-License-Identifier: GPL-2.0-or-later
# What cpack reads for each generator: which parts are in which package.
set(CPACK_INSTALL_CMAKE_PROJECTS)
if(CPACK_GENERATOR STREQUAL "DEB")
    set(CPACK_SET_DESTDIR ON) # everything has its place
    foreach(component plugin debian)
        list(APPEND CPACK_INSTALL_CMAKE_PROJECTS ${CPACK_BUILD_FOLDER} sistap ${component} /)
    endforeach()
endif()
