// One violation: a run knows no report.
#include "report/report.h"
