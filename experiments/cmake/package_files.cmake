# Run by cpack on the files of each package before it packs them: adds what Debian's policy requires.
string(TIMESTAMP date "%a, %d %b %Y %H:%M:%S +0000" UTC)
string(TIMESTAMP year "%Y" UTC)
set(version ${CPACK_PACKAGE_VERSION}-${CPACK_DEBIAN_PACKAGE_RELEASE})
foreach(component ${CPACK_COMPONENTS_ALL})
  string(TOUPPER ${component} upper)
  set(usr ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr)
  set(folder ${usr}/share/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  file(WRITE ${folder}/changelog.Debian "raylex (${version}) unstable; urgency=medium

  * raylex ${CPACK_PACKAGE_VERSION}, packaged from its build.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}
")
  file(WRITE ${folder}/copyright "Format: https://www.debian.org/doc/packaging-manuals/copyright-format/1.0/
Upstream-Name: raylex

Files: *
Copyright: ${year} raylex authors
License: Apache-2.0
 On Debian systems the text of the license is in /usr/share/common-licenses/Apache-2.0.
")
  # Python's modules are in one folder for all versions of Python 3.
  file(GLOB python ${usr}/lib/python3.*)
  if(python)
    file(RENAME ${python} ${usr}/lib/python3)
  endif()
  file(GLOB pages ${usr}/share/man/man1/*.1)
  execute_process(COMMAND gzip -9n ${folder}/changelog.Debian ${pages} COMMAND_ERROR_IS_FATAL ANY)
endforeach()
