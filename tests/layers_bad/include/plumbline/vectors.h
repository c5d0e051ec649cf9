// One violation: a public header takes a library beside Eigen.
#include <xsimd/xsimd.hpp>
