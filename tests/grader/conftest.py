"""The walls of the sandbox, as the grader's own tests have them."""

from autograder.tests.sandbox.conftest import wall as wall
