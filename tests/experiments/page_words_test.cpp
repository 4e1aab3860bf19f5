// Expressions typed into a page: its scripts, in an embedded interpreter, compared with the compiler; and the page.
#include <catch2/catch.hpp>

#include <duktape.h>
#include <algorithm>

#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

#include "browser.h"
#include "experiments/atlas/word_answers.h"
#include "experiments/job/text/json.h"
#include "experiments/report/words/page_words.h"
#include "lpe/match.h"
#include "lpe/oracle.h"
#include "lpe/program.h"
#include "lpe/vectors.h"
#include "tests/support/paths.h"
#include "tests/support/skip.h"

using namespace raylex;
using namespace raylex::test;
using raylex::experiments::Json;

namespace {

/// Runs the page's matcher.
class PageMatcher {
  public:
    PageMatcher() : context_(duk_create_heap_default(), duk_destroy_heap) {
        run(std::string(experiments::matcher_scripts()));
        run("var names = " + experiments::expression_names() +
            ";\n"
            "function guarded(work) {\n"
            "  try { return String(work()); }\n"
            "  catch (failed) { if (failed.refused === undefined) throw failed; return 'ERR ' + failed.refused; }\n"
            "}\n"
            "function bytesOf(event) {\n"
            "  event.labels = event.labels.map(raylexLpe.bytes);\n"
            "  return event;\n"
            "}\n"
            "function matchAll(q) {\n"  // one expression, several paths
            "  return guarded(function () {\n"
            "    var program = raylexLpe.compile(raylexLpe.bytes(q.text), q.dialect, names);\n"
            "    return q.paths.map(function (path) {\n"
            "      return path.map(bytesOf).reduce(program.move, program.start).nullable ? 1 : 0;\n"
            "    }).join('');\n"
            "  });\n"
            "}\n"
            "function answerAll(q) {\n"
            "  return guarded(function () {\n"
            "    q.table.events = q.table.events.map(bytesOf);\n"
            "    var program = raylexLpe.compile(raylexLpe.bytes(q.text), q.dialect, names);\n"
            "    return raylexLpe.answers(program, q.table).join('');\n"
            "  });\n"
            "}\n");
    }
    /// Returns one letter per path, "1" or "0"; or "ERR" and the reason.
    std::string match(const std::string& text, lpe::Dialect dialect, const std::vector<oracle::Path>& paths) {
        Json question = question_of(text, dialect);
        question["paths"] = Json::array();
        for (const oracle::Path& path : paths) {
            Json events = Json::array();
            for (const lpe::Event& event : path) events.push_back(json_of(event));
            question["paths"].push_back(std::move(events));
        }
        return ask("matchAll", question);
    }
    /// Returns one letter per word: "2", "1" or "0".
    std::string answers(const std::string& text, lpe::Dialect dialect, const display::WordTable& table) {
        Json question = question_of(text, dialect), events = Json::array(), words = Json::array();
        for (const lpe::Event& event : table.events) events.push_back(json_of(event));
        for (const auto& word : table.words) {
            Json letters = Json::array();
            for (const auto letter : word)
                letters.push_back(letter == display::WordAlphabet::open ? -1 : static_cast<int>(letter));
            words.push_back(std::move(letters));
        }
        question["table"] = Json{{"events", events}, {"letters", table.letters}, {"words", words}};
        return ask("answerAll", question);
    }

  private:
    static Json question_of(const std::string& text, lpe::Dialect dialect) {
        return {{"text", text}, {"dialect", dialect == lpe::Dialect::osl ? "osl" : "renderman"}};
    }
    static Json json_of(const lpe::Event& event) {
        return {{"type", std::string(1, "CRTVLBOU"[static_cast<std::size_t>(event.type)])},
                {"scatter", std::string(1, "xDGSs"[static_cast<std::size_t>(event.scatter)])},
                {"number", event.lobe_number},
                {"labels", event.labels}};
    }
    void run(const std::string& script) {
        if (duk_peval_lstring(context_.get(), script.data(), script.size()) != 0)
            FAIL(duk_safe_to_string(context_.get(), -1));
        duk_pop(context_.get());
    }
    std::string ask(const char* function, const Json& question) {
        const std::string json = experiments::json_text(question);
        duk_get_global_string(context_.get(), function);
        duk_push_lstring(context_.get(), json.data(), json.size());
        duk_json_decode(context_.get(), -1);
        if (duk_pcall(context_.get(), 1) != 0) FAIL(json << ": " << duk_safe_to_string(context_.get(), -1));
        std::string answer = duk_safe_to_string(context_.get(), -1);
        duk_pop(context_.get());
        return answer;
    }
    std::unique_ptr<duk_context, decltype(&duk_destroy_heap)> context_;
};

/// Returns the compiler's results in the format of PageMatcher.
std::string compiled_match(const std::string& text, lpe::Dialect dialect, const std::vector<oracle::Path>& paths) {
    lpe::ChannelSource source;
    source.expression = text;
    source.dialect = dialect;
    const auto program = lpe::Program::compile({&source, 1}, {.any_word = true});
    if (!program) return "ERR " + program.error().message;
    std::string found;
    for (const oracle::Path& path : paths) {
        lpe::State state = program->starts().front();
        for (const lpe::Event& event : path) state = program->next(state, program->classify(event));
        found += program->accepts_any(state) ? '1' : '0';
    }
    return found;
}

struct Tally {
    std::size_t expressions = 0, refused = 0, accepted = 0, paths = 0;
};

void compare(PageMatcher& page, const std::string& text, lpe::Dialect dialect, const std::vector<oracle::Path>& paths,
             Tally& tally) {
    const std::string expected = compiled_match(text, dialect, paths), found = page.match(text, dialect, paths);
    const bool refused = expected.rfind("ERR", 0) == 0;
    INFO("'" << text << "' in " << (dialect == lpe::Dialect::osl ? "osl" : "renderman"));
    if (refused) CHECK(found.rfind("ERR", 0) == 0);
    if (refused && found.rfind("ERR", 0) != 0) UNSCOPED_INFO(expected);
    if (!refused) CHECK(found == expected);
    ++tally.expressions;
    tally.refused += refused ? 1 : 0;
    tally.paths += paths.size();
    if (!refused) tally.accepted += static_cast<std::size_t>(std::count(expected.begin(), expected.end(), '1'));
}

/// Returns a random text of pieces of the language, valid or not.
std::string random_text(oracle::Random& random) {
    static const char* const pieces[] = {
        "C",    "L", "D",   "S8",   "G",        "<RD>",     "<T",   ">",          "[",
        "]",    "^", "(",   ")",    "|",        "*",        "+",    "?",          "{2}",
        "{0,",  "}", "&",   "-",    "!",        ".",        "'a'",  "'a*'",       "'\\*'",
        "x",    "s", " ",   "lpe:", "noclamp;", "$diffuse", "B",    "O",          "V",
        "U2",   "1", "'é'", "#\n",  "<L.>",     "diffuse",  "_key", "<.[DS]'b'>", "<R[^D]['a''b']>",
        "[^DS]"};
    std::string text = random.below(2) == 0 ? "C" : "";
    for (std::size_t count = 1 + random.below(7); count > 0; --count) text += pieces[random.below(std::size(pieces))];
    return text;
}

}  // namespace

TEST_CASE("the matcher of pages agrees with Open Shading Language on every conformance vector", "[words][vectors]") {
    PageMatcher page;
    std::ifstream file(source_dir() + "/tests/lpe/data/lpe_vectors_osl.tsv");
    std::size_t agree = 0;
    for (std::string row; std::getline(file, row);) {
        if (row.empty() || row.front() == '#') continue;
        const std::size_t first = row.find('\t'), second = row.find('\t', first + 1);
        const std::string text = row.substr(0, first), expected = row.substr(second + 1);
        const auto events = lpe::parse_events(row.substr(first + 1, second - first - 1));
        REQUIRE(events);
        const std::string found = page.match(text, lpe::Dialect::osl, {*events}).substr(0, 3);
        INFO(row << ": " << found);
        const bool good = expected == "NOCRASH" || found == expected;
        CHECK(good);
        agree += good ? 1 : 0;
    }
    CHECK(agree == 1616);
}

TEST_CASE("the matcher of pages agrees with the compiler on random expressions, valid or not",
          "[words][release-only]") {
    PageMatcher page;
    for (const lpe::Dialect dialect : {lpe::Dialect::renderman, lpe::Dialect::osl}) {
        oracle::Random random(31);
        Tally formed, any;
        for (int round = 0; round < 400; ++round) {
            std::vector<oracle::Path> paths;
            for (int p = 0; p < 40; ++p) paths.push_back(oracle::random_path(random, 7));
            const auto sequence = oracle::random_expression(random, dialect, 2 + random.below(9));
            compare(page, oracle::text_of(sequence, dialect), dialect, paths, formed);
            compare(page, random_text(random), dialect, paths, any);
        }
        // The comparison is meaningful only if all results are frequent.
        CHECK(formed.refused == 0);
        CHECK(formed.accepted > 300);
        CHECK(any.refused > 100);
        CHECK(any.expressions - any.refused > 20);
    }
}

TEST_CASE("the matcher of pages handles merged words like raylex ask", "[words]") {
    PageMatcher page;
    display::WordTable table;
    const auto events =
        lpe::parse_events("R,D,floor R,S,wall,coat T,S,ball T,s V,-,fog R,G,floor L,-,key L,- B,- O,-,'a b'");
    REQUIRE(events);
    table.events = *events;
    for (std::size_t i = 0; i < table.events.size(); ++i) table.events[i].labels.resize(i < 6 ? 2 : 1);
    table.letters = {0, 1, 2, 3, 4, 0, 5, 5, 6, 7};  // two reflections off the floor are merged, and so are two lights
    oracle::Random random(32);
    std::size_t each[3] = {0, 0, 0};
    for (int round = 0; round < 300; ++round) {
        table.words.clear();
        for (int w = 0; w < 30; ++w) {
            std::vector<display::WordTable::Letter> word;
            for (std::size_t length = random.below(5); length > 0; --length)
                word.push_back(static_cast<display::WordTable::Letter>(random.below(5)));
            // One or more scattering events, or two or more, as merged by a budget.
            for (std::size_t open = random.below(6); open > 0 && open < 3; --open)
                word.push_back(display::WordAlphabet::open);
            word.push_back(static_cast<display::WordTable::Letter>(5 + random.below(3)));
            table.words.push_back(std::move(word));
        }
        const lpe::Dialect dialect = round % 2 == 0 ? lpe::Dialect::renderman : lpe::Dialect::osl;
        static const char* const texts[] = {
            "C<RD'floor'>.*<L.'key'>", "C.*<L.>", "CD[SV]*L", "C[^S]*O", "C<T.>{0,2}.B", "C.*<.G>.*L", "C.{2}[LB]"};
        const std::string text = round % 3 == 0
                                     ? texts[random.below(std::size(texts))]
                                     : "C" + oracle::text_of(oracle::random_expression(random, dialect, 4), dialect);
        lpe::ChannelSource source;
        source.expression = text;
        source.dialect = dialect;
        const auto program = lpe::Program::compile({&source, 1});
        REQUIRE(program);
        const experiments::WordAnswers answers(table, *program);
        std::string expected;
        for (std::uint32_t w = 0; w < table.words.size(); ++w) {
            const int answer = !answers.all(w).empty() ? 2 : !answers.some(w).empty() ? 1 : 0;
            ++each[answer];
            expected += static_cast<char>('0' + answer);
        }
        INFO(text);
        CHECK(page.answers(text, dialect, table) == expected);
    }
    CHECK(each[0] > 100);
    CHECK(each[1] > 100);
    CHECK(each[2] > 100);
}

TEST_CASE("a page of an image and its atlas shows words and takes expressions", "[words][atlas]") {
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
        "  document.querySelector('.ask input').value = 'CDL';\n"
        "  document.querySelector('.ask').requestSubmit();\n"
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
    // The rendered layer and the layer from the atlas have the same value at the pointer.
    const auto values =
        all_matches(shown.out, "<code class=\"value\">([^<]*)</code><code class=\"formula\">CDL</code>");
    REQUIRE(values.size() == 2);
    CHECK(values[0][1] == values[1][1]);
    CHECK_FALSE(values[0][1].empty());
    CHECK(count_matches(shown.out, "class=\"taken\"") > 0);
    folder.write("wrong.html", page +
                                   "<script>addEventListener('load', () => {\n"
                                   "  const input = document.querySelector('.ask input');\n"
                                   "  input.value = 'C<RX>L';\n"
                                   "  input.dispatchEvent(new Event('input'));\n"
                                   "});</script>");
    const Outcome wrong = in_browser(folder, "wrong.html", "1400,1000", {".answer.fails"});
    CHECK(contains(wrong.out, "found 'X'; expected a scattering"));
}
