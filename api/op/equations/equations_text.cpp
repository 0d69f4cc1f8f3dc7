#include "api/op/equations/equations_text.h"

/* C++ has raw strings, in which the text needs no quotes and no escapes */
const char api_equations_latex[] =
#include "api/op/equations/latex.txt"
    ;
const char api_equations_matlab[] =
#include "api/op/equations/matlab.txt"
    ;
const char api_equations_python[] =
#include "api/op/equations/python.txt"
    ;
const char api_equations_curl[] =
#include "api/op/equations/curl.txt"
    ;
