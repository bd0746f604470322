# SPDX-License-Identifier: Apache-2.0
# Renames every global symbol that ARCHIVE defines and that doesn't begin with fewray_ to fewray__SYMBOL, by NM and OBJCOPY.
execute_process(COMMAND ${NM} --defined-only --extern-only --format=posix ${ARCHIVE}
  OUTPUT_VARIABLE table COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCHALL "\n[A-Za-z0-9_.]+ " names "\n${table}")
list(TRANSFORM names STRIP)
list(FILTER names EXCLUDE REGEX "^fewray_")
list(REMOVE_DUPLICATES names)
list(TRANSFORM names REPLACE "(.+)" "\\1 fewray__\\1\n")
string(CONCAT renames ${names})
file(WRITE ${ARCHIVE}.renames "${renames}")
execute_process(COMMAND ${OBJCOPY} --redefine-syms=${ARCHIVE}.renames ${ARCHIVE} COMMAND_ERROR_IS_FATAL ANY)
