# `npm ci` with an error that says what to do.
execute_process(COMMAND ${NPM} ci --no-audit --no-fund --ignore-scripts --loglevel=error RESULT_VARIABLE result)
if(NOT result EQUAL 0)
  message(FATAL_ERROR "npm could not install the parts of the report's page (see above). Without a network, build without "
                      "the report: cmake --preset release -DPLUMBLINE_REPORT=OFF")
endif()
file(TOUCH node_modules/.package-lock.json)  # as new as what was asked for, also where nothing had to be done
