# Everything a person does with a checkout. `make` alone says what there is.

BIN := .venv/bin
DEMO := demo-out

.DEFAULT_GOAL := help
.NOTPARALLEL: # two targets may both want the set-up
.PHONY: help setup setup-test demo test lint clean distclean

help: ## Say what each target does
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-11s %s\n", $$1, $$2 }' Makefile
	@echo "With another Python: make test PYTHON=/path/to/python3"
	@echo "With cvvdp's tests (some GB for PyTorch): make test CVVDP=1"

setup: ## Install what running vrlf needs: system libraries, .venv
	@sh scripts/system-packages.sh demo
	@sh scripts/venv.sh

setup-test: ## Install what the tests need as well: a screen without a monitor
	@sh scripts/system-packages.sh test
	@sh scripts/venv.sh
	@[ -z "$(CI)$(CVVDP)" ] || sh scripts/cvvdp.sh

demo: setup ## Set up, then show the whole chain: pictures and numbers in demo-out/
	@$(BIN)/vrlf demo -o $(DEMO)
	@test -f $(DEMO)/overview.png
	@echo "Open $(DEMO)/overview.png"

test: setup-test ## Set up, then run all tests
	@$(BIN)/python -m pytest

lint: setup ## Set up, then check style, format and types
	@$(BIN)/python -m ruff check .
	@$(BIN)/python -m ruff format --check .
	@$(BIN)/python -m mypy

clean: ## Remove outputs and caches, keep .venv
	@rm -rf $(DEMO) build dist .mypy_cache .ruff_cache .pytest_cache .hypothesis
	@find vrlf tests -name __pycache__ -type d -prune -exec rm -rf {} +

distclean: clean ## Remove .venv too
	@rm -rf .venv
