// One violation: lab stands beside the commands.
#include "commands/error_color.h"
