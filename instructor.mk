# The instructor's doors: they need solutions/, and the public course goes without them.

.PHONY: course release grade grade-sample feedback report public misconceptions mutants soak refuse-unmoved

SUBMITTED ?= class/submitted
RELEASED := build/.release
# How answers can be wrong, so that releases, pages and reports name it.
NAMED := build/.misconceptions
# The class that the course makes itself, apart from a real one.
SAMPLE := build/sample
HANDED_IN := $(SAMPLE)/.submitted
# Another one, whose report and feedback the site shows.
SHOWN := build/shown
SHOWN_PAGES := $(SHOWN)/.pages
# How both are graded here: empty, or --unsandboxed. `make course` asks anew.
SANDBOX := build/.sandbox
PUBLISHED := build/soak/public

course: ## set up, make the release, build the book, grade the sample class
	@$(call step,1/4,the environment,$(READY),$(VENV))
	@rm -f $(SANDBOX) && $(MAKE) $(SANDBOX)
	@$(call step,2/4,the student release and the sample pages,-j 2 $(RELEASED) $(SHOWN_PAGES),build/release)
	@$(call step,3/4,the book,$(BOOK),build/html/index.html)
	@echo '[4/4] the sample class'
	@$(MAKE) grade-sample
	@printf '\n%s\n' 'Where each thing is:'
	@printf '  %-20s %s\n' 'the book' build/html/index.html 'student release' build/release \
		'sample submissions' $(SAMPLE)/submitted 'their marks' $(SAMPLE)/graded \
		'their feedback' $(SAMPLE)/feedback 'report on the sample' $(SAMPLE)/report/index.html \
		'logs' build/log

# A step of `make course`: it says when nothing has changed, and then does nothing.
define step
if $(MAKE) -q $(3) 2>/dev/null; then echo "[$(1)] $(2): unchanged, reused ($(4))"; \
else echo "[$(1)] $(2)"; $(MAKE) $(3); fi
endef

release: $(RELEASED) ## make the student release, build/release, with a zip for each assignment

$(RELEASED): $(call files,solutions autograder/robust_slam_autograder $(LIBRARY)) _config.yml $(NAMED)
	@$(QUIETLY) release $(BIN)/autograder release
	@touch $@

# The assignments in the browser are the release's.
$(RUNTIME): $(RELEASED)

public: setup ## write the course as the public may have it, build/public
	$(BIN)/autograder public

$(HANDED_IN): $(call files,solutions) $(RELEASED)
	@mkdir -p $(SAMPLE)
	@$(BIN)/python -m solutions.classes.sample_class write build/release $(SAMPLE)/submitted
	@touch $@

grade: setup ## grade SUBMITTED (default class/submitted): <student>/<assignment>/
	@shopt -s nullglob nocaseglob; stray=($(SUBMITTED)/*.ipynb); shopt -u nullglob nocaseglob; \
	$(BIN)/autograder grade $(SUBMITTED)/*/* "$${stray[@]}"

misconceptions: $(NAMED) ## find out how answers can be wrong, as release does, to name it

$(NAMED): $(call files,solutions autograder/robust_slam_autograder $(LIBRARY)) $(READY)
	@$(QUIETLY) misconceptions $(BIN)/autograder misconceptions --answers solutions/answers
	@touch $@

feedback: setup ## write a page for each submission, class/feedback
	$(BIN)/autograder feedback --site ../../../build/html

report: setup ## write a page for each assignment, for the instructor, class/report
	$(BIN)/autograder report

# Only these classes, which the course made itself, may be graded without a sandbox. Their marks never
# reach a gradebook that real marks are in.
grade-sample $(SHOWN_PAGES): export ROBUST_SLAM_GRADEBOOK :=

$(SANDBOX): $(READY)
	@mkdir -p $(@D) && : > $@
	@$(BIN)/autograder doctor > /dev/null || { echo --unsandboxed > $@; \
		echo 'No sandbox works here (see `autograder doctor`): the sample class, which is our own,' \
		'is graded without one. Fix that before you grade anything else.'; }

# One seed, so that the pages differ only where the course does.
$(SHOWN_PAGES): $(call files,solutions autograder/robust_slam_autograder $(LIBRARY)) _config.yml \
		$(NAMED) | $(SANDBOX)
	@rm -rf $(SHOWN)
	@$(QUIETLY) shown $(SHELL) -ec " \
		$(BIN)/python -m solutions.classes.shown_class write $(SHOWN)/release $(SHOWN)/submitted; \
		$(BIN)/autograder grade $(SHOWN)/submitted/*/* $$(cat $(SANDBOX)) --out $(SHOWN)/graded --seed 0; \
		$(BIN)/python -m solutions.classes.shown_class pages $(SHOWN)/graded $(SHOWN)/pages"
	@touch $@

grade-sample: $(HANDED_IN) | $(SANDBOX)
	@$(QUIETLY) sample $(SHELL) -ec " \
		$(BIN)/autograder grade $(SAMPLE)/submitted/*/* $$(cat $(SANDBOX)) --out $(SAMPLE)/graded \
			--json $(SAMPLE)/graded/marks.json; \
		$(BIN)/autograder feedback --out $(SAMPLE)/graded --to $(SAMPLE)/feedback \
			--site ../../../html; \
		$(BIN)/autograder report --out $(SAMPLE)/graded --to $(SAMPLE)/report \
			--feedback $(SAMPLE)/feedback"
	@$(BIN)/python -m solutions.classes.sample_class table $(SAMPLE)/graded/marks.json

# Each says first what in its list is out of date.
MUTANTS := tests.course.mutants tests.grader.mutants tests.assignments.mutation
mutants: setup-dev ## plant faults in the page's solvers, grader and solutions: tests must notice
	@bad=0; for list in $(MUTANTS); do $(BIN)/python -m $$list || bad=1; done; exit $$bad

soak: ## the long tests: every sandbox, long fuzzing, mutants, a published book, plain nbgrader
	@echo 'make soak runs the long tests, for hours.'
	@$(call install,soak)
	$(PYTEST) -q --depth soak -n logical tests/assignments/test_seeds.py
	$(PYTEST) -q --depth soak autograder/tests tests/assignments/test_answers.py \
		tests/test_secrets.py tests/test_doors.py tests/test_readme.py tests/runtime \
		tests/students_page tests/operate_page tests/book tests/course/test_breaking.py tests/grader
	$(MAKE) mutants
	@# The public course, as a repository of its own.
	rm -rf $(PUBLISHED)
	$(BIN)/autograder public --out $(PUBLISHED)
	git -C $(PUBLISHED) init -q
	git -C $(PUBLISHED) add --all
	git -C $(PUBLISHED) -c user.name=soak -c user.email=soak@localhost commit -qm 'The course'
	$(MAKE) -C $(PUBLISHED) test-all STRICT=1

clean: refuse-unmoved

# Until a class had a folder of its own, its marks lay in build/.
OLD := $(wildcard $(addprefix build/,graded submitted autograded feedback report))
refuse-unmoved:
	@[ -z "$$(ls -A build/graded 2>/dev/null)" ] || { \
		echo 'build/graded holds results, so nothing was deleted. Move them to where a class is kept:'; \
		echo '  mkdir -p class && mv $(OLD) class/'; \
		echo 'If they are only the sample class, delete them: rm -r build/graded'; exit 1; }
