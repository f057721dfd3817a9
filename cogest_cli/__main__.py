"""`python -m cogest_cli`: the same program, for who has no scripts on the path."""

from cogest_cli.main import program

if __name__ == "__main__":
    program()
