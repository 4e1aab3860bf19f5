#include <duktape.h>

#include <cstdlib>
#include <fstream>
#include <iterator>
#include <utility>

#include "experiments/study/report/page/assets.h"

namespace raylex::experiments {
namespace {

Error drawing_error(duk_context* context, const std::string& what) {
    Error error;
    error.message = what + ": " + duk_safe_to_string(context, -1);
    duk_pop(context);
    return error;
}

}  // namespace

Result<std::string> read_d3() {
    const char* given = std::getenv("RAYLEX_D3");
    std::string path = given != nullptr ? given : std::string(d3_default_path());
    if (path.empty()) path = "/usr/share/javascript/d3/d3.min.js";
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
    Error error;
    error.file = path;
    if (!file || text.empty()) {
        error.message =
            "d3 cannot be read; expected version 3 of the library here, from Debian's package libjs-d3, or its path in "
            "RAYLEX_D3";
        return error;
    }
    // The text goes into <script>, which this would end.
    if (text.find("</script") != std::string::npos) {
        error.message = "this is not a plain JavaScript file: it contains </script";
        return error;
    }
    return text;
}

Result<PlotDrawer> PlotDrawer::create(const std::string& d3) {
    PlotDrawer drawer;
    duk_context* context = duk_create_heap_default();
    drawer.context_ = context;
    if (context == nullptr) return Error{"not enough memory for the interpreter that draws plots", "", 0, 0, {}, {}};
    for (const std::string_view text : {std::string_view(d3), plot_script()}) {
        if (duk_peval_lstring(context, text.data(), text.size()) != 0)
            return drawing_error(context, "the script that draws plots cannot be read (d3 of version 3 expected)");
        duk_pop(context);
    }
    return drawer;
}

PlotDrawer::PlotDrawer(PlotDrawer&& other) noexcept : context_(std::exchange(other.context_, nullptr)) {}

PlotDrawer& PlotDrawer::operator=(PlotDrawer&& other) noexcept {
    std::swap(context_, other.context_);
    return *this;
}

PlotDrawer::~PlotDrawer() {
    if (context_ != nullptr) duk_destroy_heap(static_cast<duk_context*>(context_));
}

Result<std::string> PlotDrawer::draw(const std::string& json) {
    auto* context = static_cast<duk_context*>(context_);
    duk_push_lstring(context, json.data(), json.size());
    duk_put_global_string(context, "raylexSpec");
    if (duk_peval_string(context, "raylexPlot(d3, JSON.parse(raylexSpec))") != 0)
        return drawing_error(context, "a plot cannot be drawn");
    std::string svg = duk_safe_to_string(context, -1);
    duk_pop(context);
    return svg;
}

}  // namespace raylex::experiments
