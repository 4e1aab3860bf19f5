// Compares every word of up to 8 reflections and 200 random expressions, by every integrator, with closed forms.
//
// The light of each word is known (transport/enclosure.h). The oracle of the language tests, which shares no code with
// the compiler, determines the words that an expression accepts. Errors come from independent seeds, without
// assumptions about the correlation of light paths, connections and Markov chains; Sidak's correction covers all
// channels of all integrators. The expressions are rendered once, together with the words: each is the sum of its words
// up to rounding, and so has their errors.
#include <set>

#include "tests/lpe/oracle.h"
#include "transport/enclosure.h"

using namespace render_test;
using raylex::lpe::Dialect;
using raylex::lpe::Event;
using raylex::lpe::EventType;
using raylex::lpe::Scatter;

namespace {

constexpr double kd = 0.45, ks = 0.35;
constexpr std::size_t longest = 8, random_expressions = 200;

/// The room for raylex: both lobes are in slot 2 by default, "diffuse" of the diffuse and "mirror" of the specular
/// ones.
oracle::Path path_of(const EnclosurePathString& word) {
    oracle::Path path{{EventType::camera, Scatter::none, 0, {}}};
    for (const char letter : word.reflections)
        path.push_back(letter == 'D' ? Event{EventType::reflection, Scatter::diffuse, 2, {"a", "diffuse"}}
                                     : Event{EventType::reflection, Scatter::singular, 2, {"a", "mirror"}});
    path.push_back({EventType::light, Scatter::none, 0, {""}});
    return path;
}

struct Expression {
    std::string text;
    std::vector<bool> accepts;  // by word
};

/// Returns random expressions between C and L that accept some but not all words; no two accept the same words.
std::vector<Expression> expressions_for(const std::vector<EnclosurePathString>& words) {
    const auto token = [](const std::string& text) {
        const auto& all = oracle::tokens(Dialect::renderman);
        return static_cast<std::size_t>(
            std::find_if(all.begin(), all.end(), [&](const oracle::Token& t) { return t.text == text; }) - all.begin());
    };
    oracle::Random random(8);
    std::vector<Expression> result;
    std::set<std::vector<bool>> known;
    while (result.size() < random_expressions) {
        std::vector<std::size_t> sequence{token("C"), token("(")};
        const auto inner = oracle::random_expression(random, Dialect::renderman, 2 + random.below(9));
        sequence.insert(sequence.end(), inner.begin(), inner.end());
        sequence.insert(sequence.end(), {token(")"), token("L")});
        // User events describe surfaces; no path of light contains them.
        if (std::find(inner.begin(), inner.end(), token("U2")) != inner.end()) continue;
        const auto tree = oracle::parse(sequence, Dialect::renderman);
        REQUIRE(tree != nullptr);
        Expression expression{oracle::text_of(sequence, Dialect::renderman), {}};
        for (const EnclosurePathString& word : words)
            expression.accepts.push_back(oracle::matches(*tree, path_of(word), Dialect::renderman));
        const auto accepted = std::count(expression.accepts.begin(), expression.accepts.end(), true);
        if (accepted == 0 || accepted == static_cast<std::ptrdiff_t>(words.size())) continue;
        if (known.insert(expression.accepts).second) result.push_back(expression);
    }
    return result;
}

/// Returns the expressions' values in a render, from renders of the words.
Replicates sums_of_path_strings(const Replicates& words, const std::vector<Expression>& expressions) {
    constexpr std::size_t blocks = blocks_across * blocks_across;
    Replicates sums;
    for (const std::vector<double>& found : words.of_seed) {
        std::vector<double>& of_seed = sums.of_seed.emplace_back(expressions.size() * blocks);
        for (std::size_t e = 0; e < expressions.size(); ++e)
            for (std::size_t i = 0; i < found.size(); ++i)
                if (expressions[e].accepts[i / blocks]) of_seed[e * blocks + i % blocks] += found[i];
    }
    return sums;
}

struct Method {
    const char* integrator;
    std::uint64_t samples;
    double largest_error;  ///< relative standard error of the rarest word
};

}  // namespace

TEST_CASE("Enclosure: every word of up to 8 reflections and 200 random expressions, by every integrator",
          "[enclosure][statistical][gate]") {
    // Without roulette a path meets the rarest word, of 8 mirrors, with probability (ks / (kd + ks))^8 = 1 / 746, so
    // 590,000 paths find it with a relative error of 3.6 %. Light paths end at each wall, mostly outside the camera's
    // view.
    const Method method = GENERATE(Method{"path", 256, 0.05}, Method{"bdpt", 64, 0.1}, Method{"lighttracer", 192, 0.12},
                                   Method{"pssmlt", 192, 0.15});
    CAPTURE(method.integrator);
    const bool light_tracer = method.integrator == std::string("lighttracer");
    const std::vector<EnclosurePathString> words = enclosure_path_strings(kd, ks, longest);
    REQUIRE(words.size() == 511);
    static const std::vector<Expression> expressions = expressions_for(words);
    std::vector<ClosedForm> of_path_strings, of_expressions;
    std::size_t missed = 0;
    for (const EnclosurePathString& word : words) {
        const bool found = !light_tracer || light_tracer_finds(word);
        missed += found ? 0 : 1;
        std::string text = "C";
        for (const char letter : word.reflections) text += letter == 'D' ? "<RD>" : "<RS>";
        of_path_strings.push_back({text + "L", found ? word.value : 0});
    }
    CHECK(missed == (light_tracer ? 255 : 0));  // a mirror and up to 7 further reflections
    for (const Expression& expression : expressions) {
        double sum = 0;
        for (std::size_t w = 0; w < words.size(); ++w) sum += expression.accepts[w] ? of_path_strings[w].value : 0;
        of_expressions.push_back({expression.text, sum});
    }

    auto description = scene_of(enclosure(kd, ks, 100));
    REQUIRE(description.shapes.size() == 1);
    description.shapes[0].label = "a";
    auto built = transport::BuiltScene::build(description);
    REQUIRE(built.ok());
    transport::RenderSettings settings;
    settings.paths.max_depth = static_cast<std::int64_t>(longest);  // so that no word is longer than those above
    settings.channels.beauty = false;
    settings.machine.threads = 2;
    settings.samples.per_pixel = method.samples;
    settings.paths.integrator = integrator_named(method.integrator);
    if (method.integrator == std::string("pssmlt")) settings.paths.integrator = metropolis(64, 10000);
    settings.paths.integrator->parameters.parameters.push_back(flag_parameter("roulette", false));
    const auto render = [&](const std::vector<ClosedForm>& forms, int seeds) {
        settings.channels.list.clear();
        for (const ClosedForm& each : forms) {
            settings.channels.list.push_back(
                lpe_channel("c" + std::to_string(settings.channels.list.size()), each.expression));
            settings.channels.list.back().statistics = false;
        }
        return replicates(**built, settings, static_cast<int>(forms.size()), seeds, 8000);
    };
    const std::size_t tests = 4 * (of_path_strings.size() + of_expressions.size());
    const Replicates found = render(of_path_strings, 16), sums = sums_of_path_strings(found, expressions);
    check_closed_forms(found, of_path_strings, tests, method.largest_error);
    check_closed_forms(sums, of_expressions, tests, method.largest_error);

    // All together: chains go where any channel finds light, so chains for words alone would differ.
    std::vector<ClosedForm> all = of_path_strings;
    all.insert(all.end(), of_expressions.begin(), of_expressions.end());
    Replicates once = render(all, 1);
    std::vector<double>& image = once.of_seed[0];
    const auto end_of_path_strings =
        image.begin() + static_cast<std::ptrdiff_t>(image.size() / all.size() * words.size());
    const std::vector<double> at_once(end_of_path_strings, image.end());
    image.erase(end_of_path_strings, image.end());
    const std::vector<double> sum = sums_of_path_strings(once, expressions).of_seed[0];
    REQUIRE(at_once.size() == sum.size());
    for (std::size_t i = 0; i < at_once.size(); ++i) {
        INFO(of_expressions[i / 9].expression << " block " << i % 9);
        CHECK(std::abs(at_once[i] - sum[i]) <= 1e-12 * at_once[i]);  // bound of Law 1
    }
}
