#include "experiments/study/report/page/picture_viewers.h"

#include <algorithm>
#include <utility>

#include "experiments/job/text/json.h"
#include "experiments/report/html.h"

namespace raylex::experiments {
namespace {

std::string button(const std::string& attributes, const std::string& name) {
    return "<button type=\"button\" aria-pressed=\"false\" " + attributes + ">" + escape_html(name) + "</button>";
}

std::string slider(const char* name, const char* label, const char* range) {
    return std::string("<label>") + label + " <input class=\"" + name + "\" type=\"range\" " + range +
           " value=\"0\"></label>";
}

std::string viewer(const ScenePictures& pictures, std::size_t index) {
    std::string channels, chips, against;
    for (const std::string& channel : pictures.channels) channels += button("data-channel", channel);
    for (std::size_t i = 0; i < pictures.images.size(); ++i) {
        const std::string& name = pictures.images[i].name;
        chips += button("data-image", name);
        against += "<option value=\"" + std::to_string(i) + "\"" +
                   (i + 1 == pictures.images.size() ? " selected" : "") + ">" + escape_html(name) + "</option>";
    }
    return "<h3>" + escape_html(pictures.scene) + "</h3>\n<div class=\"bench\" tabindex=\"-1\" data-scene=\"" +
           std::to_string(index) +
           "\">\n<div class=\"tools\"><span class=\"faint\">Channel</span><span class=\"group\">" + channels +
           "</span></div>\n<div class=\"tools\"><span class=\"faint\">Images</span><span class=\"group\">" + chips +
           "</span></div>\n<div class=\"tools\"><span class=\"group\">" + button("data-mode=\"side\"", "side by side") +
           button("data-mode=\"flip\"", "flip") + button("data-mode=\"split\"", "split") +
           button("data-mode=\"difference\"", "difference") + "</span><span class=\"for-light tools\">" +
           slider("exposure", "exposure", "min=\"-10\" max=\"10\" step=\"0.1\"") +
           "<span class=\"stops\" title=\"back to 0\"></span></span><span class=\"for-difference tools\" "
           "hidden><label>from "
           "<select class=\"against\">" +
           against + "</select></label>" + slider("gain", "gain", "min=\"-4\" max=\"8\" step=\"0.25\"") +
           "<span class=\"times\"></span></span><span class=\"group\"><button type=\"button\" "
           "data-fit>fit</button><button "
           "type=\"button\" data-actual>1:1</button></span><button type=\"button\" class=\"clear\" hidden>clear "
           "insets</button></div>\n<div class=\"panes\" style=\"--shape:" +
           std::to_string(pictures.width) + "/" + std::to_string(pictures.height) +
           "\"></div>\n<div class=\"colorbar\" hidden><span class=\"ramp\"></span><span class=\"marks\">"
           "<span class=\"mark\"></span><span class=\"mark\"></span><span class=\"mark\"></span><span "
           "class=\"mark\"></span>"
           "<span class=\"mark\"></span></span></div>\n<p class=\"status\"></p><div class=\"wide\"><table "
           "class=\"readout\"><thead></thead><tbody></tbody></table></div></div>\n";
}

}  // namespace

Json picture_index(const Study& study, const Pictures& pictures) {
    Json json = Json::array();
    for (const ScenePictures& scene : pictures.scenes) {
        Json images = Json::array(), insets = Json::array();
        for (const PictureSet& set : scene.images) {
            Json ids = Json::array();
            for (const std::optional<std::size_t>& id : set.ids) ids.push_back(id ? Json(*id) : Json(nullptr));
            images.push_back(Json{{"name", set.name}, {"ids", std::move(ids)}});
        }
        for (const Region& region : study.experiment->regions)
            if ((region.scene.empty() || region.scene == scene.scene) && region.crop[2] > region.crop[0])
                insets.push_back(Json{{"x", region.crop[0] / scene.block},
                                      {"y", region.crop[1] / scene.block},
                                      {"w", std::max(1, (region.crop[2] - region.crop[0]) / scene.block)},
                                      {"h", std::max(1, (region.crop[3] - region.crop[1]) / scene.block)}});
        json.push_back(Json{{"scene", scene.scene},
                            {"width", scene.width},
                            {"height", scene.height},
                            {"block", scene.block},
                            {"channels", scene.channels},
                            {"images", std::move(images)},
                            {"insets", std::move(insets)}});
    }
    return json;
}

std::string image_viewers(const Pictures& pictures) {
    std::string html =
        "<section id=\"images\">\n<h2>Images</h2>\n<p class=\"faint\">The first replicate of every variant's largest "
        "budget, scene-linear at half precision (11 significant bits), shown by the sRGB curve";
    if (!pictures.scenes.empty() && pictures.scenes.front().block > 1)
        html += ", reduced " + std::to_string(pictures.scenes.front().block) + " times to keep this page small";
    html +=
        ". Drag moves and, with Shift, draws an inset; double click fits. With the viewer in focus the wheel zooms, "
        "<b>g</b> puts images side by side, <b>f</b> flips them, <b>s</b> splits under the pointer, <b>d</b> "
        "subtracts, left "
        "and right change the channel. Differences are relative to the image chosen, the mean over red, green and "
        "blue, dark "
        "pixels judged as a tenth of its mean. Shares are of the first channel, by the sum of red, green and "
        "blue.</p>\n";
    for (std::size_t i = 0; i < pictures.scenes.size(); ++i) html += viewer(pictures.scenes[i], i);
    for (const std::string& each : pictures.left_out)
        html += "<p class=\"note\">Left out: " + escape_html(each) + "</p>\n";
    return html + "</section>\n";
}

}  // namespace raylex::experiments
