# One file of what three.js here names, with its licence at the beginning, which asks to be in every copy.
execute_process(COMMAND ${ESBUILD} ${ENTRY} --bundle --minify --format=esm --target=es2022 --legal-comments=eof --log-level=warning
  --outfile=${OUTPUT}.part COMMAND_ERROR_IS_FATAL ANY)
file(READ ${LICENCE} licence)
file(READ ${OUTPUT}.part code)
file(WRITE ${OUTPUT} "/*! three.js\n\n${licence}*/\n")
file(APPEND ${OUTPUT} "${code}")
file(REMOVE ${OUTPUT}.part)
