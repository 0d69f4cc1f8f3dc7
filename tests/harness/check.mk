# What `make check` runs, as jobs side by side: three builds, every test program on them, valgrind, the rules.
# ONLY='asan-% build-asan' picks jobs.
# Leaves to others: running a job and counting (job.sh).
# Invariant: a job that fails, crashes or cannot start is counted as failed and the others go on.
ROOMS := core laws api server wire fuzz
# in this order they are begun as soon as what they need is there: what others need or what waits longest, the rest
ALL := build-release web release-core release-wire build-asan build-tsan valgrind-core release-server release-api asan-wire tsan-wire \
	drill histories school asan-core asan-server asan-api valgrind-api tsan-server base-core clients restart clang operators valgrind-fuzz \
	asan-fuzz base-api openapi engine asan-laws readback image types valgrind-wire same equations gains valgrind-server valgrind-laws layers \
	nginx replies examples guides growth deploy release-laws release-fuzz layout measures mirror words tour install instructions hardened packages \
	docs fetch
JOBS := $(if $(ONLY),$(filter $(ONLY),$(ALL)),$(ALL))
job = @tests/harness/job.sh $@

check: $(JOBS)
$(shell mkdir -p build/check; echo $(JOBS) > build/check/jobs)

build-release build-asan: build-%:
	$(job) $(MAKE) --no-print-directory MODE=$* build build/$*/pendulum $(ROOMS:%=build/$*/tests/%/run) build/$*/tests/drill/clock.so $(if $(filter release,$*),build/release/libpendulum.so)
build-tsan:
	$(job) $(MAKE) --no-print-directory MODE=tsan build build/tsan/tests/server/run build/tsan/tests/wire/run
# what only computes leaves the processors to the first build; what waits for servers then waits beside it
build-asan build-tsan clang openapi types: | $(filter build-release,$(JOBS))

# what mostly waits for servers runs as two processes side by side
LANES.wire := env TEST_LANES=2
LANES.server := env TEST_LANES=2
# fresh memory holds nonsense, so that a number that was never set is a wrong one
$(ROOMS:%=release-%): release-%: build-release
	$(job) env MALLOC_PERTURB_=85 $(LANES.$*) build/release/tests/$*/run
# What a sanitizer only slows, as it is about time, bits or a process that is killed: the release run has it. Of downloads from a
# database that goes, the thread sanitizer has both tests and the address sanitizer the shorter one.
SLOWED := -=results_of_a_job_are_those_of_a_request_bit_for_bit -=a_job_says_how_long_it_will_take_and_means_it \
	-=a_trajectory_killed_in_mid_part_goes_on_with_the_same_bits \
	-=a_branch_of_orbits_killed_in_mid_part_goes_on_with_the_same_bits -=a_daemon_killed_at_any_instant_loses_no_job_and_no_bit \
	-=a_process_that_slept_takes_nothing_from_itself -=a_silent_stream_has_a_heartbeat -=a_job_that_kills_its_workers_is_given_up \
	-=a_job_is_forgotten_when_it_was_kept_for_its_time -=each_role_may_what_it_may -=each_bad_key_has_its_status_and_its_sentence
SLOWED.asan-wire := $(SLOWED) -=downloads_bear_a_database_that_falls_silent_or_goes_and_nobody_else_waits
SLOWED.tsan-wire := $(SLOWED)
# Statistics of many draws, which other tests make one by one: fits with each loss, models that are rejected, valleys, orbits of
# trees of every kind. The release run looks at the numbers; each kernel of the base instruction set has references of its own.
STATISTICS := -=bifurcations_of_random_trees_are_where_multipliers_pass_the_circle_and_nowhere_else \
	-=bifurcations_at_which_driven_trees_lose_their_symmetry_are_told_from_both_sides \
	-=standard_errors_of_robust_losses_hold_beside_outliers -=standard_errors_hold_beside_noise_that_is_alike \
	-=independent_noise_rejects_no_model_but_for_its_size -=searches_in_a_curved_valley_go_on_to_its_lowest_place
SLOWED.base-core := $(STATISTICS) -=fits_of_several_chaotic_runs_find_the_pendulum_or_say_that_they_do_not
# failing allocations and hints do not depend on the instruction set
SLOWED.base-api := -=whichever_allocation_fails_a_job_is_computed_or_fails_for_want_of_memory \
	-=whichever_allocation_fails_a_call_ends_cleanly -=wrong_requests_of_fits_are_told_what_helps
# Digits of many motions: release and base look at the numbers. They run no line and no branch of core that the
# others here do not run too (gcov, for each instruction set), so the address sanitizer would look at the same accesses again.
SLOWED.asan-core := $(STATISTICS) -=horizon_of_random_trees_is_seldom_late_and_never_by_a_tenth -=modes_vectors_of_equal_arms \
	-=modes_vectors_of_seven_kinds_of_600_arms -=orbits_switch_through_a_cascade_of_doublings_as_feigenbaum_says \
	-=section_finds_as_many_passages_as_a_fine_look_at_the_motion
SLOWED.asan-laws := -=law_the_driven_damped_pendulum_doubles_its_period_where_its_multiplier_is_minus_1 \
	-=law_the_pendulum_of_baker_and_gollub_goes_to_chaos_and_back -=tolerances_bound_the_error_of_a_run \
	-=tolerances_can_be_the_tightest_of_a_method -=whole_turns_of_a_free_spin_add_up \
	-=the_balance_of_energy_holds_over_a_thousand_seconds_with_everything_on \
	-=law_fast_form_is_the_matrix_form_for_random_trees_of_200_arms -=law_an_arm_stands_upside_down_from_kapitzas_threshold_on
# Altered rows of PostgreSQL come by the same code as those of SQLite, once they are read; the release run has a third of them.
SLOWED.asan-server := -=no_altered_row_harms_more_than_its_job_on_postgresql
SLOWED.tsan-server := $(SLOWED.asan-server)
# as on a processor without AVX2; nothing is compiled again
base-core base-api: base-%: build-release
	@$(MAKE) --no-print-directory build/release/tests/base/$*
	$(job) build/release/tests/base/$* $(SLOWED.$@)
$(ROOMS:%=asan-%): asan-%: build-asan
	$(job) $(LANES.$*) build/asan/tests/$*/run $(SLOWED.$@)

# the thread sanitizer of gcc 12 cannot bear the address randomization of newer kernels
FIXED := $(shell setarch $$(uname -m) -R echo setarch $$(uname -m) -R 2>/dev/null)
tsan-wire: tsan-%: build-tsan
	$(job) $(LANES.$*) $(FIXED) build/tsan/tests/$*/run $(SLOWED.$@)
# Of the server's tests all but those that began no thread in the release run, where it is one of the jobs: one thread has no race.
# A test of which that run says nothing, or something that cannot be read, is asked about.
SINGLE := $(if $(filter release-server,$(JOBS)),build/check/release-server.log) /dev/null
tsan-server: build-tsan $(filter release-server,$(JOBS))
	$(job) $(LANES.server) $(FIXED) build/tsan/tests/server/run $(SLOWED.$@) $$(sed -nE 's/^ok +([^ ]+) \([0-9.]+ s, [0-9.]+ s of processors\)$$/-=\1/p' $(SINGLE))

# without names: the tests that took little time in the release run
VALGRIND.wire := =every_route_answers =requests_that_cannot_be_answered_are_refused_with_their_problem \
	=pipelined_requests_are_answered_in_their_order \
	=malformed_messages_are_refused_and_the_connection_closed =a_body_that_stops_in_the_middle_gets_408 \
	=a_drain_lets_the_running_request_finish
VALGRIND.fuzz := =fuzz_corpora_are_replayed
$(ROOMS:%=valgrind-%): valgrind-%: release-%
	$(job) tests/harness/valgrind.sh build/release $* $(VALGRIND.$*)

# a few of each fault; make drill has fifty
drill: build-release
	$(job) tests/drill/drill.sh build/release
# one failover of each kind; make histories has ten
histories: build-release
	$(job) /usr/bin/python3 -B tests/drill/histories.py build/release --rounds 1
# ten seconds of the day; make school has five minutes
school: build-release
	$(job) /usr/bin/python3 -B tests/drill/school.py build/release
layers: build-release
	$(job) tests/rules/layers.sh build/release
docs web readback fetch install same hardened packages image: build-release
	$(job) tests/rules/$@.sh build/release
replies: release-wire
	$(job) /usr/bin/python3 -B tests/rules/replies.py build/release/tests/wire/replies.ndjson
instructions: build-release
	@$(MAKE) --no-print-directory build/release/tests/bench/instructions/run
	$(job) tests/rules/instructions.sh build/release
layout types words clang openapi:
	$(job) tests/rules/$@.sh
engine: build-release
	@$(MAKE) --no-print-directory build/release/tests/engine/native
	$(job) tests/rules/engine.sh build/release
clients deploy equations gains examples growth guides nginx operators restart: build-release
	$(job) /usr/bin/python3 -B tests/rules/$@.py build/release
tour: build-release
	$(job) /usr/bin/python3 -B tests/rules/tour.py build/release --check
measures mirror:
	$(job) /usr/bin/python3 -B tests/rules/$@.py

.PHONY: check $(ALL)
