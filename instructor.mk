# The instructor's doors: they need solutions/, and the public course goes without them.

.PHONY: course release class grade grade-class feedback report public mutants soak

SUBMITTED ?= build/submitted
RELEASED := build/.release
CLASS := build/.class
BENCHES += grading

course: ## set up, build the book, make the release, grade the sample class
	@$(call step,1/4,the environment,$(READY),$(VENV))
	@$(call step,2/4,the book,$(BOOK),build/html/index.html)
	@$(call step,3/4,the student release,$(RELEASED),build/release)
	@$(call step,4/4,the sample class,$(CLASS),build/submitted)
	@$(MAKE) grade-class
	@printf '\n%s\n' 'Where each thing is:'
	@printf '  %-18s %s\n' 'the book' build/html/index.html 'student release' build/release \
		'sample class' build/submitted 'marks, gradebook' build/graded \
		'feedback' build/feedback 'class report' build/report

# A step of `make course`: it says when nothing has changed, and then does nothing.
define step
if $(MAKE) -q $(3) 2>/dev/null; then echo "[$(1)] $(2): unchanged, reused ($(4))"; \
else echo "[$(1)] $(2) …"; $(MAKE) $(3); fi
endef

release: $(RELEASED) ## make the student release, build/release, with a zip for each assignment

$(RELEASED): $(call files,solutions autograder/robust_slam_autograder) _config.yml $(READY)
	$(BIN)/autograder release
	@touch $@

public: setup ## write the course as the public may have it, build/public
	$(BIN)/autograder public

class: $(CLASS)

$(CLASS): $(call files,solutions tests/assignments) tests/sample_class.py $(RELEASED)
	$(BIN)/python -m tests.sample_class build/release build/submitted
	@touch $@

grade: setup ## grade SUBMITTED (default build/submitted): <student>/<assignment>/
	$(BIN)/autograder grade $(SUBMITTED)/*/*

feedback: setup ## write a page for each submission, build/feedback
	$(BIN)/autograder feedback --site ../../html

report: setup ## write a page for each assignment, for the instructor, build/report
	$(BIN)/autograder report

# Only this class, which the course made itself, may be graded without a sandbox.
grade-class:
	@$(BIN)/autograder doctor > /dev/null || { flag=--unsandboxed; \
		echo 'No sandbox works here (see `autograder doctor`): the sample class, which is our own,' \
		'is graded without one. Mend that before you grade anything else.'; }; \
	$(BIN)/autograder grade build/submitted/*/* $$flag; \
	$(BIN)/autograder feedback --site ../../html; \
	$(BIN)/autograder report

mutants: setup ## change the reference solutions, and see that the assignments' cases notice
	$(BIN)/python -m tests.assignments.mutation

soak: setup ## the long tests: every wall and user, long fuzzing, a published book, plain nbgrader
	@sh tests/system-packages.sh
	$(BIN)/python -m tests.autograder.hostile.soak
	$(BIN)/pytest -q --soak tests/autograder tests/assignments/test_answers.py \
		tests/test_secrets.py tests/test_ci_doors.py
	$(BIN)/python -m benchmarks.attacks
