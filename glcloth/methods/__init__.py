"""The three methods for cloth under an environment: direct, paper, reference."""
