"""The back ends of the sandbox, as the grader's own tests have them."""

from autograder.tests.conftest import pytest_generate_tests as pytest_generate_tests
