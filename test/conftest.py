"""Options of the tests of this folder."""


def pytest_addoption(parser):
    parser.addoption(
        "--regen",
        action="store_true",
        help="write today's values into test/golden/*.json and fail with what has changed",
    )
