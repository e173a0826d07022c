// What knead verify measures by, and that it sees what is wrong: planted errors.
#include "host/verify/verify.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "cuda/mpm/material.h"
#include "cuda/mpm/plasticity.h"
#include "host/base/errors.h"
#include "host/base/outputs.h"
#include "host/solver/audit.h"
#include "host/solver/substep.h"
#include "host/verify/cases.h"
#include "host/verify/oracle.h"
#include "host/verify/squeeze.h"
#include "tests/folder.h"

namespace knead {
namespace {

VerifyOptions quiet()
{
    VerifyOptions o;
    o.device = "cpu", o.quick = true, o.quiet = true, o.threads = 1;
    return o;
}

double size(const Sym3<double>& A) { return std::sqrt(norm_squared(A)); }

TEST(Verify, ABoundHoldsOnItsOwnSideOnlyAndForNumbersOnly)
{
    EXPECT_EQ(near("", 1.02, 1, 0.03, "").verdict, Verdict::passed);
    EXPECT_EQ(near("", 1.04, 1, 0.03, "").verdict, Verdict::failed);
    EXPECT_EQ(near("", 0.96, 1, 0.03, "").verdict, Verdict::failed);
    EXPECT_EQ(at_most("", 1, 1, "").verdict, Verdict::passed);
    EXPECT_EQ(at_most("", 1.01, 1, "").verdict, Verdict::failed);
    EXPECT_EQ(at_least("", 1, 1, "").verdict, Verdict::passed);
    EXPECT_EQ(at_least("", 0.99, 1, "").verdict, Verdict::failed);
    for (const double x : {std::nan(""), double(INFINITY), -double(INFINITY)}) {
        EXPECT_EQ(near("", x, 1, 1e300, "").verdict, Verdict::failed);
        EXPECT_EQ(at_most("", x, 1e300, "").verdict, Verdict::failed);
        EXPECT_EQ(at_least("", x, -1e300, "").verdict, Verdict::failed);
    }
}

// Small strain: Hooke's law, which neither form was made from.
TEST(Verify, TheOracleIsHookesLawForSmallStrains)
{
    Material<double> m = elastic(1e6, 0.3, 1000);
    const Sym3<double> strain{1e-6, -2e-6, 3e-6, 4e-6, -1e-6, 2e-6};
    for (const Elasticity elasticity :
         {Elasticity::neo_hookean, Elasticity::fixed_corotated, Elasticity::hencky}) {
        m.elasticity = elasticity;
        const oracle::StressState s = oracle::solid(m, 2.0 * strain);
        const Sym3<double> hooke = raised(2 * m.mu * strain, m.lambda * trace(strain));
        EXPECT_LT(size(s.tau + -1.0 * hooke), 2e-5 * size(hooke));
        EXPECT_NEAR(s.energy,
                    m.mu * norm_squared(strain) + m.lambda / 2 * trace(strain) * trace(strain),
                    1e-4 * s.energy);
        EXPECT_NEAR(s.log_J, trace(strain), 1e-10);
    }
}

// Stretch by 2 along x without change of volume is a stress by hand.
TEST(Verify, TheOracleIsTheLawByHandAtLargeStretch)
{
    Material<double> m = elastic(1e6, 0.3, 1000);
    const Sym3<double> e{3, 0.5 - 1, 0.5 - 1, 0, 0, 0};
    EXPECT_NEAR(oracle::solid(m, e).tau.xx, 3 * m.mu, 1e-6 * m.mu);
    m.elasticity = Elasticity::hencky;
    EXPECT_NEAR(oracle::solid(m, e).tau.xx, 2 * m.mu * std::log(2.0), 1e-6 * m.mu);
    m.elasticity = Elasticity::fixed_corotated;
    EXPECT_NEAR(oracle::solid(m, e).tau.xx, 4 * m.mu, 1e-6 * m.mu);
    EXPECT_NEAR(oracle::solid(m, e, 3).tau.xx, 12 * m.mu, 1e-6 * m.mu);
}

TEST(Verify, ALawThatIsAThousandthOffIsSeen)
{
    oracle::Draw draw(4);
    Material<double> m = elastic(1e6, 0.3, 1000), planted = m;
    planted.mu *= 1.001;
    Particle<double> q{};
    q.e = draw.strain(0.7, 1.4);
    const Sym3<double> right = oracle::solid(m, q.e).tau;
    EXPECT_LT(size(kirchhoff_stress(q, m) + -1.0 * right), 1e-11 * size(right));
    EXPECT_GT(size(kirchhoff_stress(q, planted) + -1.0 * right), 1e-5 * size(right));
}

TEST(Verify, AnExplodingCaseFailsAndASoundOneDoesNot)
{
    Verification v(quiet());
    Case c{"ball", block_on_floor(elastic(1e5, 0.3, 1000))};
    c.end = 0.05, c.frame = 0.005;
    EXPECT_EQ(outcome_of(v, c, 60).ending, Ending::stable);
    c.setup.step.fixed = 6 * choose_dt(step_limits(c.setup), {}, 1, 1).dt;
    const Outcome wild = outcome_of(v, c, 60);
    EXPECT_EQ(wild.ending, Ending::failed) << wild.note;
    c.setup.step.fixed = 0;
    c.end = 100;
    EXPECT_EQ(outcome_of(v, c, 0.05).ending, Ending::slow);
}

TEST(Verify, AChildThatCrashesHangsOrTalksNonsenseIsAFailureThatSaysSo)
{
    const auto by = [](const char* script, double late) {
        return outcome_by({"sh", "-c", script}, late);
    };
    const Outcome crash = by("kill -SEGV $$", 60), hang = by("exec sleep 60", 0.2),
                  code = by("exit 4", 60), nonsense = by("echo '{\"ending\": \"stable\"}'", 60);
    for (const Outcome& o : {crash, hang, code, nonsense}) EXPECT_EQ(o.ending, Ending::failed);
    EXPECT_EQ(crash.note.find("ended by signal 11"), 0u) << crash.note;
    EXPECT_EQ(hang.note.find("hung"), 0u) << hang.note;
    EXPECT_EQ(code.note, "ended with exit code 4");
    EXPECT_EQ(nonsense.note, "told no outcome");
}

TEST(Verify, AnOutcomeIsToldAndHeardAlike)
{
    Outcome o;
    o.ending = Ending::guarded, o.note = "clipped 3";
    o.stats[Count::clipped] = 3, o.stats.substeps = 9, o.stats.dt_min = 1e-5;
    o.energy_gain = std::nan(""), o.volume = 0.25, o.crowded = 0.5;
    const Outcome same = parse_outcome(nlohmann::json::parse(json_of(o).dump()));
    EXPECT_EQ(same.ending, Ending::guarded);
    EXPECT_EQ(same.note, "clipped 3");
    EXPECT_EQ(same.stats[Count::clipped], 3);
    EXPECT_EQ(same.stats.substeps, 9);
    EXPECT_EQ(same.stats.dt_min, 1e-5);
    EXPECT_TRUE(std::isnan(same.energy_gain));
    EXPECT_EQ(same.volume, 0.25);
    EXPECT_EQ(same.crowded, 0.5);
}

class InVerifyFolder : public InFolder {};

// A program that crashes in one case and takes its time in the first.
TEST_F(InVerifyFolder, CasesGoOnInTheirOrderWhenOneCrashes)
{
    Outcome good;
    good.ending = Ending::stable;
    write_whole(path("program"),
                "#!/bin/sh\n[ $3 = crash ] && kill -SEGV $$\n"
                "[ $3 = first ] && sleep 0.3\necho '" +
                    json_of(good).dump() + "'\n");
    std::filesystem::permissions(path("program"), std::filesystem::perms::owner_all);
    VerifyOptions o = quiet();
    o.program = path("program"), o.threads = 3;
    Verification v(o);
    std::vector<Case> cases(3);
    cases[0].name = "first", cases[1].name = "crash", cases[2].name = "last";
    std::string order;
    outcomes_of(v, cases, [&](const Case& c, const Outcome& out) {
        order += c.name + " " + ending_name(out.ending) + "; ";
    });
    EXPECT_EQ(order, "first stable; crash FAILED; last stable; ");
}

TEST(Verify, VolumeThatNothingExplainsIsSilent)
{
    const knead::Setup s = block_on_floor(plastic(1e6, 0.4, 1000, 1e4));
    const Audit before = audit(s.particles, s.materials, s.lattice.dx);
    Audit after = before;
    EXPECT_EQ(silent_error(s, before, after), "");
    after.volume = 1.02 * before.volume;
    EXPECT_EQ(silent_error(s, before, after), "");
    after.volume = 1.04 * before.volume;
    EXPECT_EQ(silent_error(s, before, after).find("silent: volume is off by 4 %"), 0u);
    after.volume = 0.96 * before.volume;
    EXPECT_NE(silent_error(s, before, after), "");
    after.kinetic = s.materials[0].bulk * before.volume * 0.03 * 0.03 / 2;
    EXPECT_EQ(silent_error(s, before, after), "");
    after.volume = std::nan("");
    EXPECT_NE(silent_error(s, before, after), "");
}

TEST(Verify, ClayWithinClayIsGuardedNotStable)
{
    Verification v(quiet());
    Case c{"two blocks in one place", block_on_floor(elastic(1e5, 0.3, 1000))};
    const Place floor = floor_of(c.setup), reach{0.03, 0, 0.03};
    c.end = 0.02, c.frame = 0.005;
    EXPECT_EQ(outcome_of(v, c, 60).crowded, 0);
    fill(c.setup, elastic(1e5, 0.3, 1000), floor - reach, floor + reach + Place{0, 0.04, 0}, 2);
    const Outcome o = outcome_of(v, c, 60);
    EXPECT_EQ(o.ending, Ending::guarded) << o.note;
    EXPECT_GT(o.crowded, 0.4);
    EXPECT_NE(o.note.find("crowded"), std::string::npos) << o.note;
}

TEST(Verify, EnergyIsThatOfHeightMotionAndStrain)
{
    knead::Setup s = block_on_floor(elastic(1e5, 0.3, 1000));
    s.particles.resize(1);
    Particle<double>& q = s.particles[0];
    q.x = floor_of(s) + Place{0, 0.03, 0};
    const double mass = s.materials[0].mass;
    EXPECT_NEAR(energy_of(s.particles, s), mass * 9.81 * 0.03, 1e-12);
    q.v = {3, 0, 4};
    EXPECT_NEAR(energy_of(s.particles, s), mass * (9.81 * 0.03 + 12.5), 1e-12);
    q.C = {{0, 2, 0}, {-2, 0, 0}, {0, 0, 0}};
    EXPECT_NEAR(energy_of(s.particles, s), mass * (9.81 * 0.03 + 12.5 + 0.5 * 1e-4 / 4 * 8), 1e-12);
}

// In float and in double: half of the clay pushed, and nothing else changed.
TEST(Verify, AChangeBetweenFramesIsOfTheParticlesMeantAndLasts)
{
    for (const char* device : {"cpu", "reference"}) {
        VerifyOptions o = quiet();
        o.device = device;
        Verification v(o);
        knead::Setup s = block_on_floor(elastic(1e5, 0.3, 1000));
        s.gravity = {};
        auto solver = v.solver(s);
        solver->advance({}, 1e-3);
        change(v, solver, s, [](std::vector<Particle<double>>& all) {
            for (std::size_t i = 0; i < all.size() / 2; ++i) all[i].v.x += 0.25;
        });
        const std::vector<Particle<double>> now = by_id(*solver);
        ASSERT_EQ(now.size(), s.particles.size());
        for (std::size_t i = 0; i < now.size(); ++i) {
            EXPECT_NEAR(now[i].v.x, i < now.size() / 2 ? 0.25 : 0, 1e-12) << device;
            EXPECT_NEAR(length(now[i].x - s.particles[i].x), 0, 1e-7) << device;
        }
        solver->advance({}, 1e-3);
        const Audit after = audit(solver->particles(), s.materials, s.lattice.dx);
        EXPECT_NEAR(after.momentum.x, after.mass * 0.125, 1e-6 * after.mass) << device;
    }
}

// A ball as two clouds of other spacing, one of them turned, shifted and bent by a known amount.
TEST(Verify, ShapesAreComparedWithoutTheirRigidMotion)
{
    const auto cloud = [](double apart, const auto& map) {
        Squeezed s;
        s.apart = apart;
        const int n = int(squeeze_radius / apart);
        for (int z = -n; z < n; ++z)
            for (int y = -n; y < n; ++y)
                for (int x = -n; x < n; ++x) {
                    const Place p = apart * Place{x + 0.5, y + 0.5, z + 0.5};
                    if (length(p) < squeeze_radius) s.from.push_back(p), s.to.push_back(map(p));
                }
        return s;
    };
    const auto stretched = [](Place p) { return Place{0.8 * p.x, 1.1 * p.y, 1.1 * p.z}; };
    const Quat<double> turn = turn_about(Vec3<double>{0, 0, 1}, 0.2);
    const auto moved = [&](Place p) { return rotate(turn, stretched(p)) + Place{0.03, 0.04, 0}; };
    const Squeezed fine = cloud(0.02, stretched), coarse = cloud(0.04, moved);
    const Apart same = apart(carried(coarse), carried(fine));
    EXPECT_GT(same.matched, 1500u);
    EXPECT_LT(same.rms, 1e-12);
    EXPECT_NEAR(same.turn, 0.2, 1e-9);
    EXPECT_NEAR(same.shift, 0.05, 1e-3);  // the probes are even about the middle
    const Squeezed bent = cloud(0.04, [&](Place p) {
        return moved(p) + Place{0, 0, p.x > 0 ? 0.002 : -0.002};
    });
    EXPECT_GT(apart(carried(bent), carried(fine)).rms, 2e-4);
}

TEST(Verify, ResultsAreWholeInEveryForm)
{
    VerifyOptions o = quiet();
    o.suites = {"accuracy"}, o.only = "shear";
    Verification v(o);
    run(v);
    ASSERT_EQ(v.checks.size(), 3u);
    v.add(near("planted \"error\"", 2, 1, 0.5, "m", "mend it"));
    v.add(VerifyRow{"table", "case", "stable", {{"seconds", 1.5}}});
    const nlohmann::json all = verify_json(v);
    EXPECT_EQ(all["checks"].size(), 4u);
    EXPECT_GE(all["failed"].get<int>(), 1);
    EXPECT_EQ(all["checks"][3]["verdict"], "FAILED");
    EXPECT_EQ(all["rows"][0]["numbers"]["seconds"], 1.5);
    EXPECT_NE(verify_csv(v).find("\"planted \"\"error\"\"\",2,near,1,0.5"), std::string::npos);
    EXPECT_NE(verify_page(v).find("mend it"), std::string::npos);
    EXPECT_NE(verify_page(v).find("| case | stable | 1.5 |"), std::string::npos);
    EXPECT_EQ(verify_page(v).find("!["), std::string::npos);
    EXPECT_NE(verify_page(v, {"margins.png"}).find("![margins](margins.png)"), std::string::npos);
    EXPECT_NE(verify_text(v.checks[3]).find("FAILED"), std::string::npos);
}

TEST(Verify, WhatIsNotThereIsRefused)
{
    VerifyOptions o = quiet();
    o.suites = {"acuracy"};
    EXPECT_THROW(Verification{o}, UsageError);
    o = quiet(), o.only = "nothing of this name";
    Verification v(o);
    EXPECT_THROW(run(v), UsageError);
    o = quiet(), o.device = "gpu";
    EXPECT_THROW(Verification{o}, UsageError);
}

}  // namespace
}  // namespace knead
