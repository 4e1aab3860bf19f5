// Expressions that are typed into a page: the page's script in a browser against the compiler, and the page itself.
#include <catch2/catch.hpp>

#include <algorithm>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "experiments/atlas/path_string_answers.h"
#include "experiments/job/text/json.h"
#include "experiments/report/html.h"
#include "experiments/report/words/page_path_strings.h"
#include "lpe/match.h"
#include "lpe/oracle.h"
#include "lpe/program.h"
#include "tests/experiments/browser.h"
#include "tests/support/paths.h"
#include "tests/support/skip.h"

using namespace raylex;
using namespace raylex::test;
using raylex::experiments::Json;

namespace {

/// Questions for the page's script. One browser answers all of them.
class PageQuestions {
  public:
    /// The answer has a digit for each path, 1 if the expression matches it; or "ERR" and a column.
    void add_paths(const std::string& text, const std::vector<oracle::Path>& paths) {
        Json question{{"text", text}, {"paths", Json::array()}};
        for (const oracle::Path& path : paths) {
            question["paths"].push_back(Json::array());
            for (const lpe::Event& event : path) question["paths"].back().push_back(number_of(event));
        }
        questions_.push_back(std::move(question));
    }
    /// The answer has a digit for each path string: 2, 1 or 0.
    void add_table(const std::string& text, const display::PathStringTable& table) {
        Json events = Json::array(), words = Json::array();
        for (const lpe::Event& event : table.events) events.push_back(json_of(event));
        for (const auto& word : table.words) {
            words.push_back(Json::array());
            for (const auto letter : word)
                words.back().push_back(letter == display::PathAlphabet::open ? -1 : static_cast<int>(letter));
        }
        questions_.push_back(
            {{"text", text}, {"table", {{"events", events}, {"letters", table.letters}, {"words", words}}}});
    }
    /// One answer a question. None: the browser did not answer.
    std::vector<std::string> ask(const Folder& folder) const {
        const Json all{{"events", events_}, {"questions", questions_}};
        folder.write("questions.html",
                     "<body><script type=\"application/json\" id=\"questions\">" +
                         experiments::script_json(experiments::json_text(all)) + "</script>\n<script>" +
                         std::string(experiments::lpe_script()) +
                         "</script>\n<script>\n"
                         "const names = " +
                         experiments::script_json(experiments::expression_names()) +
                         ";\n"
                         "const { events, questions } = JSON.parse(document.getElementById('questions').textContent);\n"
                         "const answer = ({ text, paths, table }) => {\n"
                         "  try {\n"
                         "    const expression = raylexLpe.parse(text, names), { algebra, root } = expression;\n"
                         "    if (table) return raylexLpe.answers(expression, table).join('');\n"
                         "    const end = path => path.reduce((node, i) => algebra.move(node, events[i]), root);\n"
                         "    return paths.map(path => end(path).nullable ? 1 : 0).join('');\n"
                         "  } catch (failed) {\n"
                         "    if (failed.offset === undefined) throw failed;\n"
                         "    return `ERR ${failed.offset + 1}`;\n"
                         "  }\n"
                         "};\n"
                         "const list = document.body.appendChild(document.createElement('pre'));\n"
                         "list.textContent = questions.map(answer).join('\\n') + '\\n';\n"
                         "list.id = 'answers';\n"
                         "</script></body>");
        const Outcome page = in_browser(folder, "questions.html", "800,600", {"#answers"});
        INFO(page.err.substr(0, 2000));
        CHECK(page.err.find("Uncaught") == std::string::npos);
        const std::size_t begin = page.out.find("<pre id=\"answers\">");
        REQUIRE(begin != std::string::npos);
        std::istringstream lines(page.out.substr(begin + 18, page.out.find("</pre>") - begin - 18));
        std::vector<std::string> answers;
        for (std::string line; std::getline(lines, line);) answers.push_back(line);
        REQUIRE(answers.size() == questions_.size());
        return answers;
    }

  private:
    static Json json_of(const lpe::Event& event) {
        return {{"type", std::string(1, "CRTVLBOU"[static_cast<std::size_t>(event.type)])},
                {"scatter", std::string(1, "xDGSs"[static_cast<std::size_t>(event.scatter)])},
                {"number", event.lobe_number},
                {"labels", event.labels}};
    }
    std::size_t number_of(const lpe::Event& event) {
        const auto [place, fresh] = numbers_.emplace(lpe::to_text(event), events_.size());
        if (fresh) events_.push_back(json_of(event));
        return place->second;
    }
    Json questions_ = Json::array(), events_ = Json::array();
    std::map<std::string, std::size_t> numbers_;
};

/// The compiler's answer, in the form of PageQuestions.
std::string compiled_answer(const std::string& text, const std::vector<oracle::Path>& paths) {
    lpe::ChannelSource source;
    source.expression = text;
    const auto program = lpe::Program::compile({&source, 1}, {.any_path_string = true});
    if (!program) return "ERR " + std::to_string(program.error().column);
    std::string found;
    for (const oracle::Path& path : paths) {
        lpe::State state = program->starts().front();
        for (const lpe::Event& event : path) state = program->next(state, program->classify(event));
        found += program->accepts_any(state) ? '1' : '0';
    }
    return found;
}

/// A text of pieces of the language, well-formed or not. It has no names with '$' and no prefixes: the compiler
/// replaces names before it parses, so it can report a later error first.
std::string random_text(oracle::Random& random) {
    static const char* const pieces[] = {"C",  "L",    "D",       "S8",   "G",          "<RD>",  "<T",
                                         ">",  "[",    "]",       "^",    "(",          ")",     "|",
                                         "*",  "+",    "?",       "{2}",  "{0,",        "}",     "&",
                                         "-",  "!",    ".",       "'a'",  "'a*'",       "'\\*'", "x",
                                         "s",  " ",    "1",       "lpe:", "B",          "O",     "V",
                                         "U2", "<L.>", "diffuse", "_key", "<.[DS]'b'>", "[^DS]", "<R[^D]['a''b']>"};
    std::string text = random.below(2) == 0 ? "C" : "";
    for (std::size_t count = 1 + random.below(7); count > 0; --count) text += pieces[random.below(std::size(pieces))];
    return text;
}

/// Asks the browser and the compiler about expressions and paths, and compares the answers.
class Comparison {
  public:
    void add(const std::string& text, const std::vector<oracle::Path>& paths, const std::string& expected) {
        questions_.add_paths(text, paths);
        texts_.push_back(text);
        expected_.push_back(expected);
    }
    void add(const std::string& text, const std::vector<oracle::Path>& paths) {
        add(text, paths, compiled_answer(text, paths));
    }
    void run() const {
        const Folder folder;
        const std::vector<std::string> found = questions_.ask(folder);
        for (std::size_t i = 0; i < found.size(); ++i) {
            INFO("'" << texts_[i] << "'");
            CHECK(found[i] == expected_[i]);
        }
    }
    [[nodiscard]] std::size_t refused() const {
        return static_cast<std::size_t>(std::count_if(expected_.begin(), expected_.end(),
                                                      [](const std::string& each) { return each.starts_with("ERR"); }));
    }
    [[nodiscard]] std::size_t size() const { return expected_.size(); }

  private:
    PageQuestions questions_;
    std::vector<std::string> texts_, expected_;
};

std::vector<oracle::Path> random_paths(oracle::Random& random) {
    std::vector<oracle::Path> paths;
    for (int p = 0; p < 40; ++p) paths.push_back(oracle::random_path(random, 7));
    return paths;
}

}  // namespace

// The vectors are for osl. Their expressions have a meaning in renderman too, often a different one.
TEST_CASE("a page answers as the compiler does on the conformance vectors and on random expressions",
          "[words][vectors][release-only][gate][gate]") {
    const Folder folder;
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    Comparison comparison;
    std::ifstream file(source_dir() + "/tests/lpe/data/lpe_vectors_osl.tsv");
    for (std::string row; std::getline(file, row);) {
        if (row.empty() || row.front() == '#') continue;
        const std::size_t first = row.find('\t'), second = row.find('\t', first + 1);
        const auto events = lpe::parse_events(row.substr(first + 1, second - first - 1));
        REQUIRE(events);
        const std::string text = row.substr(0, first);
        // Prefixes of these vectors change light, which the compiler leaves to the renderer.
        if (contains(text, ";")) comparison.add(text, {*events}, "ERR 1");
        else comparison.add(text, {*events});
    }
    REQUIRE(comparison.size() == 1616);
    oracle::Random random(31);
    for (int round = 0; round < 400; ++round) {
        const auto sequence = oracle::random_expression(random, lpe::Dialect::renderman, 2 + random.below(9));
        comparison.add(oracle::text_of(sequence, lpe::Dialect::renderman), random_paths(random));
        comparison.add(random_text(random), random_paths(random));
    }
    const auto accented = lpe::parse_events("C,- R,D,\xC3\xA9 L,-");
    REQUIRE(accented);
    for (const char* text :
         {"C # the camera\n <RD'?'> L", "C<RD'*?'>L", "C<RD'\xC3\xA9'>L", "$diffuse", "C(${diffuse})*", "$diffuse_key",
          "C|$nothing L", "diffusion", "s1t3;C.*L", "beyond7;CDL", "s1t0;CDL"})
        comparison.add(text, {*accented});
    CHECK(comparison.refused() > 300);
    comparison.run();
}

TEST_CASE("a page answers merged path strings as raylex ask does", "[words][gate][gate]") {
    const Folder folder;
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    display::PathStringTable table;
    const auto events =
        lpe::parse_events("R,D,floor R,S,wall,coat T,S,ball T,s V,-,fog R,G,floor L,-,key L,- B,- O,-,'a b'");
    REQUIRE(events);
    table.events = *events;
    for (std::size_t i = 0; i < table.events.size(); ++i) table.events[i].labels.resize(i < 6 ? 2 : 1);
    table.letters = {0, 1, 2, 3, 4, 0, 5, 5, 6, 7};  // two reflections off the floor are merged, and so are two lights
    oracle::Random random(32);
    PageQuestions questions;
    std::vector<std::string> texts, expected;
    std::size_t each[3] = {0, 0, 0};
    for (int round = 0; round < 200; ++round) {
        table.words.clear();
        for (int w = 0; w < 30; ++w) {
            std::vector<display::PathStringTable::Letter> word;
            for (std::size_t length = random.below(5); length > 0; --length)
                word.push_back(static_cast<display::PathStringTable::Letter>(random.below(5)));
            // One or more scattering events, or two or more, as merged by a budget.
            for (std::size_t open = random.below(6); open > 0 && open < 3; --open)
                word.push_back(display::PathAlphabet::open);
            word.push_back(static_cast<display::PathStringTable::Letter>(5 + random.below(3)));
            table.words.push_back(std::move(word));
        }
        static const char* const pool[] = {
            "C<RD'floor'>.*<L.'key'>", "C.*<L.>", "CD[SV]*L", "C[^S]*O", "C<T.>{0,2}.B", "C.*<.G>.*L", "C.{2}[LB]"};
        const auto sequence = oracle::random_expression(random, lpe::Dialect::renderman, 4);
        texts.push_back(round % 3 == 0 ? pool[random.below(std::size(pool))]
                                       : "C" + oracle::text_of(sequence, lpe::Dialect::renderman));
        questions.add_table(texts.back(), table);
        lpe::ChannelSource source;
        source.expression = texts.back();
        const auto program = lpe::Program::compile({&source, 1});
        REQUIRE(program);
        const experiments::PathStringAnswers answers(table, *program);
        std::string digits;
        for (std::uint32_t w = 0; w < table.words.size(); ++w) {
            const int answer = !answers.all(w).empty() ? 2 : !answers.some(w).empty() ? 1 : 0;
            ++each[answer];
            digits += static_cast<char>('0' + answer);
        }
        expected.push_back(digits);
    }
    for (const std::size_t count : each) CHECK(count > 100);
    const std::vector<std::string> found = questions.ask(folder);
    for (std::size_t i = 0; i < found.size(); ++i) {
        INFO(texts[i]);
        CHECK(found[i] == expected[i]);
    }
}

TEST_CASE("a page of an image and its atlas shows path strings and answers expressions", "[words][atlas][gate][gate]") {
    const SceneFolder folder;
    REQUIRE(run_raylex(folder, "render room.pbrt -o a.exr --atlas a.atlas.exr --lpe direct=CDL").code == 0);
    REQUIRE(run_raylex(folder, "render room.pbrt -o b.exr --seed 9").code == 0);
    REQUIRE(run_raylex(folder, "report a.exr a.atlas.exr -o page.html").code == 0);
    const std::string page = folder.read("page.html");
    CHECK(count_matches(page, "<section class=\"image\">") == 1);
    CHECK(contains(page, "class=\"words\">{\"name\":\"a.atlas.exr\""));
    CHECK_FALSE(contains(page, "<code>atlas/words</code>"));
    // An atlas of another render is shown separately, and so is a single one.
    REQUIRE(run_raylex(folder, "report b.exr a.atlas.exr -o two.html").code == 0);
    CHECK(count_matches(folder.read("two.html"), "<section class=\"image\">") == 2);
    REQUIRE(run_raylex(folder, "report a.atlas.exr -o alone.html").code == 0);
    CHECK(count_matches(folder.read("alone.html"), "class=\"words\">\\{") == 1);
    if (!has_browser(folder)) RAYLEX_SKIP("needs the package chromium");
    const std::string act =
        "<script>addEventListener('load', () => {\n"
        "  const [input, dialect, form] = ['input', 'select', ''].map(each => document.querySelector('.ask ' + "
        "each));\n"
        "  const answer = document.querySelector('.ask .answer'), copy = () => "
        "document.body.append(answer.cloneNode(true));\n"
        "  input.value = 'C<RX>L';\n"
        "  input.dispatchEvent(new Event('input'));\n"
        "  copy();\n"
        "  [input.value, dialect.value] = ['C<Ts>L', 'osl'];\n"
        "  form.requestSubmit();\n"
        "  copy();\n"
        "  [input.value, dialect.value] = ['CDL', 'renderman'];\n"
        "  form.requestSubmit();\n"
        "  const canvas = document.querySelector('.pane canvas'), box = canvas.getBoundingClientRect();\n"
        "  canvas.dispatchEvent(new PointerEvent('pointermove', { clientX: box.left + box.width / 2,\n"
        "    clientY: box.top + 0.75 * box.height }));\n"
        "});</script>";
    folder.write("acted.html", page + act);
    const Outcome shown =
        in_browser(folder, "acted.html", "1400,1000", {"[data-asked=CDL]", ".words td", "[data-read=yes]"});
    CAPTURE(shown.err);
    CHECK(shown.err.find("Uncaught") == std::string::npos);
    REQUIRE_FALSE(shown.out.empty());
    // The layer that was rendered and the one that was typed have the same value at the pointer.
    const auto values =
        all_matches(shown.out, "<code class=\"value\">([^<]*)</code><code class=\"formula\">CDL</code>");
    REQUIRE(values.size() == 2);
    CHECK(values[0][1] == values[1][1]);
    CHECK_FALSE(values[0][1].empty());
    CHECK(count_matches(shown.out, "class=\"taken\"") > 0);
    const auto said = all_matches(shown.out, "<p class=\"answer( fails)?\">([^<]*)</p>");
    REQUIRE(said.size() == 3);
    CHECK(contains(said[1][2], "column 4: found 'X'; expected "));
    CHECK(said[1][1] == " fails");
    CHECK(contains(said[2][2], "raylex ask 'a.atlas.exr' --dialect osl --lpe 'asked=C&lt;Ts&gt;L' -o layers.exr"));
    CHECK(contains(said[0][2], "raylex ask 'a.atlas.exr' --lpe 'asked=CDL' -o layers.exr"));
}
